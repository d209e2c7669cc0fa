/* The calibrated origins of all joints as YAML. */
#include "io/export.h"

static void print_effects(FILE *stream, const mukca_export_input *input)
{
    if (input->offsets->n_effects > 0) fputs("effects:\n", stream);
    for (int e = 0; e < input->offsets->n_effects; e++) {
        const mukca_effect *effect = &input->offsets->effects[e];
        const char *joint = mukca_chain_joint_name(input->chain, effect->joint);
        for (int t = 0; t < effect->terms; t++) {
            char term[MUKCA_EFFECT_TEXT];
            mukca_effect_term_text(term, effect, t);
            mukca_export_print(
                stream, "  - effect: $s\n    joint: ", mukca_effect_table[effect->kind]->name);
            mukca_export_print(stream, joint ? "$q" : "null", joint);
            mukca_export_print(stream,
                               "\n    term: \"$s\"\n    unit: \"$s\"\n    coefficient: $n\n", term,
                               mukca_effect_unit(effect, input->chain), effect->coefficient[t]);
        }
    }
}

static mukca_status write_yaml(FILE *stream, const mukca_export_input *input)
{
    const mukca_chain *chain = input->chain;
    mukca_export_provenance(stream, "# ", input);
    mukca_export_print(
        stream,
        "# Each origin maps the joint's child frame to its parent frame: xyz in m, rpy in rad "
        "with\n"
        "# R = Rz(yaw) Ry(pitch) Rx(roll), quaternion as w, x, y, z; use it in place of the "
        "URDF's.\n"
        "robot: $q\nbase: $q\ntip: $q\nurdf_sha256: $q\njoints:\n",
        chain->robot, chain->base, chain->tip, chain->urdf_sha256);
    for (int k = 0; k < chain->n_elements; k++) {
        const mukca_element *e = &chain->element[k];
        mukca_export_origin origin;
        mukca_export_get_origin(&origin, input, k);
        mukca_export_print(stream, "  - name: $q\n    type: $s\n", e->name,
                           mukca_joint_type_name[e->type]);
        if (e->type != MUKCA_FIXED) mukca_export_print(stream, "    axis: [$c]\n", e->axis, 3);
        mukca_export_print(stream, "    xyz: [$c]\n    rpy: [$c]\n    quaternion: [$c]\n",
                           origin.xyz, 3, origin.rpy, 3, origin.quaternion, 4);
    }
    print_effects(stream, input);
    return MUKCA_OK;
}

const mukca_export_format mukca_export_yaml = {
    .write = write_yaml, .holds_all = true, .comment = {"#", "\n"}};
