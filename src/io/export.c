/* The table of exporters, and what they share; YAML. */
#include "io/export.h"

#include <string.h>

#include "mukca/version.h"

const mukca_exporter mukca_exporters[] = {
#define EXPORTER_ROW(name, function, what) {#name, what, function},
    MUKCA_EXPORT_LIST(EXPORTER_ROW)
#undef EXPORTER_ROW
        {NULL, NULL, NULL}};

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

void mukca_export_quoted(FILE *stream, const char *text)
{
    fputc('"', stream);
    for (; *text; text++) {
        if ((unsigned char)*text < ' ') continue;
        if (*text == '"' || *text == '\\') fputc('\\', stream);
        fputc(*text, stream);
    }
    fputc('"', stream);
}

/* A name in a comment: nothing that could end it. */
static void print_plain(FILE *stream, const char *text)
{
    for (; *text; text++)
        fputc((unsigned char)*text < ' ' || (text[0] == '*' && text[1] == '/') ? ' ' : *text,
              stream);
}

void mukca_export_provenance(FILE *stream, const char *prefix, const mukca_export_input *input)
{
    char when[32];
    mukca_offsets_time(when);
    fprintf(stream, "%sWritten by mukca " MUKCA_VERSION " on %s from ", prefix, when);
    print_plain(stream, base_name(input->urdf_path));
    if (input->offsets_path) {
        fputs(" and ", stream);
        print_plain(stream, base_name(input->offsets_path));
    }
    fprintf(stream, ".\n%sRobot ", prefix);
    print_plain(stream, input->chain->robot);
    fputs(", from link ", stream);
    print_plain(stream, input->chain->base);
    fputs(" to ", stream);
    print_plain(stream, input->chain->tip);
    fprintf(stream, ".\n%sSHA-256 of the URDF: %s\n", prefix, input->chain->urdf_sha256);
}

void mukca_export_origin(double xyz[3], double rpy[3], double quaternion[4],
                         const mukca_export_input *input, int element)
{
    const double *theta = input->offsets->theta + MUKCA_PARAMETERS * element;
    double R[9];
    memcpy(xyz, theta, 3 * sizeof *xyz);
    memcpy(rpy, theta + 3, 3 * sizeof *rpy);
    mukca_rotation_from_rpy(R, rpy);
    mukca_rotation_to_quaternion(quaternion, R);
}

static void print_list(FILE *stream, const char *key, const double *values, int n)
{
    fprintf(stream, "    %s: [", key);
    for (int i = 0; i < n; i++) fprintf(stream, "%s%.17g", i ? ", " : "", values[i]);
    fputs("]\n", stream);
}

mukca_status mukca_export_yaml(FILE *stream, const mukca_export_input *input, mukca_error *error)
{
    static const char *const type[] = {"fixed", "revolute", "continuous", "prismatic"};
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
        double xyz[3], rpy[3], quaternion[4];
        mukca_export_origin(xyz, rpy, quaternion, input, k);
        fputs("  - name: ", stream);
        mukca_export_quoted(stream, chain->element[k].name);
        fprintf(stream, "\n    type: %s\n", type[chain->element[k].type]);
        if (chain->element[k].type != MUKCA_FIXED)
            print_list(stream, "axis", chain->element[k].axis, 3);
        print_list(stream, "xyz", xyz, 3);
        print_list(stream, "rpy", rpy, 3);
        print_list(stream, "quaternion", quaternion, 4);
    }
    if (input->offsets->n_effects == 0) return MUKCA_OK;
    fputs("effects:\n", stream);
    for (int e = 0; e < input->offsets->n_effects; e++) {
        const mukca_effect *effect = &input->offsets->effects[e];
        for (int t = 0; t < effect->terms; t++) {
            char term[48];
            mukca_effect_term_text(term, effect, t);
            fprintf(stream, "  - effect: %s\n    joint: ", mukca_effect_table[effect->kind].name);
            if (effect->joint < 0)
                fputs("null", stream);
            else
                mukca_export_quoted(stream,
                                    chain->element[chain->joint_element[effect->joint]].name);
            fprintf(stream, "\n    term: \"%s\"\n    unit: \"%s\"\n    coefficient: %.17g\n", term,
                    mukca_effect_table[effect->kind].unit, effect->coefficient[t]);
        }
    }
    return MUKCA_OK;
}
