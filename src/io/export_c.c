/* A C header of const arrays with the calibrated chain. */
#include <ctype.h>
#include <string.h>

#include "io/export.h"

/* A C identifier from a robot's name. */
static void identifier(char name[MUKCA_NAME_SIZE], const char *robot)
{
    size_t n = 0;
    for (; *robot && n < 40; robot++)
        name[n++] = (char)(isalnum((unsigned char)*robot) ? tolower((unsigned char)*robot) : '_');
    name[n] = '\0';
    if (n == 0 || isdigit((unsigned char)name[0])) {
        memmove(name + 2, name, n + 1);
        memcpy(name, "r_", 2);
    }
}

static void print_numbers(FILE *stream, const double *values, int n)
{
    fputs("    {", stream);
    mukca_export_numbers(stream, values, n, ", ");
    fputs("},\n", stream);
}

static void print_use(FILE *stream, const char *id)
{
    fprintf(
        stream,
        " *\n"
        " * Element k maps its child frame to its parent frame; the tip in the base frame is "
        "their\n"
        " * product from first to last.  xyz is in m, rpy in rad.  Use:\n"
        " *\n"
        " *     T = identity;\n"
        " *     for (int k = 0; k < %s_elements; k++) {\n"
        " *         R = rotation of %s_quaternion[k];            // w, x, y, z; the same as rpy\n"
        " *         T = T * (R, %s_xyz[k]);\n"
        " *         if (%s_joint[k] < 0) continue;               // fixed\n"
        " *         if (%s_prismatic[k]) T = T * (I, %s_axis[k] * q[%s_joint[k]]);\n"
        " *         else T = T * (rotation about %s_axis[k] by q[%s_joint[k]], 0);\n"
        " *     }\n"
        " */\n",
        id, id, id, id, id, id, id, id, id);
}

static void print_effects(FILE *stream, const char *id, const mukca_export_input *input)
{
    const mukca_offsets *o = input->offsets;
    if (o->n_effects == 0) return;
    fprintf(
        stream,
        "\n/* Effects beyond the geometry; `mukca help effects` explains them, libmukca_core "
        "applies\n"
        " * them.  joint: index into q, -1 where the effect has none. */\n"
        "static const struct {\n    const char *effect;\n    int joint;\n    const char *term;\n"
        "    double coefficient; /* SI */\n} %s_effects[] = {\n",
        id);
    for (int e = 0; e < o->n_effects; e++)
        for (int t = 0; t < o->effects[e].terms; t++) {
            char term[MUKCA_EFFECT_TEXT];
            mukca_effect_term_text(term, &o->effects[e], t);
            fprintf(stream, "    {\"%s\", %d, \"%s\", ",
                    mukca_effect_table[o->effects[e].kind]->name, o->effects[e].joint, term);
            mukca_export_numbers(stream, &o->effects[e].coefficient[t], 1, "");
            fputs("},\n", stream);
        }
    fputs("};\n", stream);
}

/* Arrays by element: names, origins and axes. */
static void print_arrays(FILE *stream, const char *id, const mukca_export_input *input)
{
    const mukca_chain *chain = input->chain;
    const int n = chain->n_elements;
    fprintf(stream, "\nstatic const char *const %s_name[%d] = {\n", id, n);
    for (int k = 0; k < n; k++) {
        fputs("    ", stream);
        mukca_export_quoted(stream, chain->element[k].name);
        fputs(",\n", stream);
    }
    static const char *const array[] = {"xyz", "rpy", "quaternion", "axis"};
    static const int width[] = {3, 3, 4, 3};
    for (int a = 0; a < 4; a++) {
        fprintf(stream, "};\n\nstatic const double %s_%s[%d][%d] = {\n", id, array[a], n, width[a]);
        for (int k = 0; k < n; k++) {
            mukca_export_origin origin;
            mukca_export_get_origin(&origin, input, k);
            const double *const values[] = {origin.xyz, origin.rpy, origin.quaternion,
                                            chain->element[k].axis};
            print_numbers(stream, values[a], width[a]);
        }
    }
    fprintf(stream,
            "};\n\n/* index into q, -1 for a fixed joint */\nstatic const int %s_joint[%d] = {", id,
            n);
    for (int k = 0; k < n; k++) fprintf(stream, "%s%d", k ? ", " : "", chain->element[k].joint);
    fprintf(stream, "};\nstatic const int %s_prismatic[%d] = {", id, n);
    for (int k = 0; k < n; k++)
        fprintf(stream, "%s%d", k ? ", " : "", chain->element[k].type == MUKCA_PRISMATIC);
    fputs("};\n", stream);
}

static mukca_status write_c(FILE *stream, const mukca_export_input *input, mukca_error *error)
{
    const mukca_chain *chain = input->chain;
    char id[MUKCA_NAME_SIZE] = "", guard[MUKCA_NAME_SIZE] = "";
    (void)error;
    identifier(id, chain->robot);
    for (size_t i = 0; i < sizeof guard; i++) guard[i] = (char)toupper((unsigned char)id[i]);
    fputs("/* Calibrated kinematics as const arrays.\n *\n", stream);
    mukca_export_provenance(stream, " * ", input);
    print_use(stream, id);
    fprintf(stream, "#ifndef %s_KINEMATICS_H\n#define %s_KINEMATICS_H\n\n", guard, guard);
    fprintf(stream, "enum { %s_elements = %d, %s_joints = %d };\n", id, chain->n_elements, id,
            chain->n_joints);
    print_arrays(stream, id, input);
    print_effects(stream, id, input);
    fputs("\n#endif\n", stream);
    return MUKCA_OK;
}

const mukca_export_format mukca_export_c = {.write = write_c, .comment = {"/*", "*/"}};
