/* The calibrated origins of all joints as YAML. */
#include "io/export.h"

static void print_list(FILE *stream, const char *key, const double *values, int n)
{
    fprintf(stream, "    %s: [", key);
    mukca_export_numbers(stream, values, n, ", ");
    fputs("]\n", stream);
}

static void print_effects(FILE *stream, const mukca_export_input *input)
{
    if (input->offsets->n_effects > 0) fputs("effects:\n", stream);
    for (int e = 0; e < input->offsets->n_effects; e++) {
        const mukca_effect *effect = &input->offsets->effects[e];
        const char *joint = mukca_chain_joint_name(input->chain, effect->joint);
        for (int t = 0; t < effect->terms; t++) {
            char term[MUKCA_EFFECT_TEXT];
            mukca_effect_term_text(term, effect, t);
            fprintf(stream, "  - effect: %s\n    joint: ", mukca_effect_table[effect->kind]->name);
            if (joint)
                mukca_export_quoted(stream, joint);
            else
                fputs("null", stream);
            fprintf(stream, "\n    term: \"%s\"\n    unit: \"%s\"\n    coefficient: ", term,
                    mukca_effect_table[effect->kind]->unit);
            mukca_export_numbers(stream, &effect->coefficient[t], 1, "");
            fputc('\n', stream);
        }
    }
}

static mukca_status write_yaml(FILE *stream, const mukca_export_input *input, mukca_error *error)
{
    const mukca_chain *chain = input->chain;
    (void)error;
    mukca_export_provenance(stream, "# ", input);
    fputs(
        "# Each origin maps the joint's child frame to its parent frame: xyz in m, rpy in rad "
        "with\n"
        "# R = Rz(yaw) Ry(pitch) Rx(roll), quaternion as w, x, y, z; use it in place of the "
        "URDF's.\n",
        stream);
    const char *const keys[] = {"robot", "base", "tip", "urdf_sha256"};
    const char *const values[] = {chain->robot, chain->base, chain->tip, chain->urdf_sha256};
    for (int i = 0; i < 4; i++) {
        fprintf(stream, "%s: ", keys[i]);
        mukca_export_quoted(stream, values[i]);
        fputc('\n', stream);
    }
    fputs("joints:\n", stream);
    for (int k = 0; k < chain->n_elements; k++) {
        mukca_export_origin origin;
        mukca_export_get_origin(&origin, input, k);
        fputs("  - name: ", stream);
        mukca_export_quoted(stream, chain->element[k].name);
        fprintf(stream, "\n    type: %s\n", mukca_joint_type_name[chain->element[k].type]);
        if (chain->element[k].type != MUKCA_FIXED)
            print_list(stream, "axis", chain->element[k].axis, 3);
        print_list(stream, "xyz", origin.xyz, 3);
        print_list(stream, "rpy", origin.rpy, 3);
        print_list(stream, "quaternion", origin.quaternion, 4);
    }
    print_effects(stream, input);
    return MUKCA_OK;
}

const mukca_export_format mukca_export_yaml = {.write = write_yaml, .comment = {"#", "\n"}};
