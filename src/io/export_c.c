/* The calibrated chain as const arrays in a C header. */
#include <ctype.h>
#include <string.h>

#include "io/export.h"

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

/* Print arrays by element: names, origins and axes. */
static void print_arrays(FILE *stream, const char *id, const mukca_export_input *input)
{
    const mukca_chain *chain = input->chain;
    const int n = chain->n_elements;
    signed char joint[MUKCA_MAX_ELEMENTS], slides[MUKCA_MAX_ELEMENTS];
    fprintf(stream, "\nstatic const char *const %s_name[%d] = {\n", id, n);
    for (int k = 0; k < n; k++) mukca_export_print(stream, "    $q,\n", chain->element[k].name);
    static const char *const array[] = {"xyz", "rpy", "quaternion", "axis"};
    static const int width[] = {3, 3, 4, 3};
    for (int a = 0; a < 4; a++) {
        fprintf(stream, "};\n\nstatic const double %s_%s[%d][%d] = {\n", id, array[a], n, width[a]);
        for (int k = 0; k < n; k++) {
            mukca_export_origin origin;
            mukca_export_get_origin(&origin, input, k);
            const double *const values[] = {origin.xyz, origin.rpy, origin.quaternion,
                                            chain->element[k].axis};
            mukca_export_print(stream, "    {$c},\n", values[a], width[a]);
        }
    }
    for (int k = 0; k < n; k++) {
        joint[k] = (signed char)chain->element[k].joint;
        slides[k] = chain->element[k].type == MUKCA_PRISMATIC;
    }
    mukca_export_print(stream,
                       "};\n\n/* index into q, -1 for a fixed joint */\n"
                       "static const int $s_joint[$i] = {$l};\n"
                       "static const int $s_prismatic[$i] = {$l};\n",
                       id, n, joint, n, id, n, slides, n);
}

/* ---- the arm for libmukca_rt ---- */

static void print_chain(FILE *stream, const mukca_chain *chain)
{
    static const char *const type[] = {[MUKCA_FIXED] = "MUKCA_FIXED",
                                       [MUKCA_REVOLUTE] = "MUKCA_REVOLUTE",
                                       [MUKCA_CONTINUOUS] = "MUKCA_CONTINUOUS",
                                       [MUKCA_PRISMATIC] = "MUKCA_PRISMATIC"};
    mukca_export_print(stream,
                       "    .chain = {.robot = $q, .base = $q, .tip = $q,\n"
                       "        .urdf_sha256 = $q,\n"
                       "        .n_elements = $i, .n_joints = $i, .n_masses = $i,\n"
                       "        .gravity = {$c},\n        .element = {\n",
                       chain->robot, chain->base, chain->tip, chain->urdf_sha256, chain->n_elements,
                       chain->n_joints, chain->n_masses, chain->gravity, 3);
    for (int k = 0; k < chain->n_elements; k++) {
        const mukca_element *e = &chain->element[k];
        mukca_export_print(stream,
                           "            {.name = $q, .child = $q, .type = $s, .joint = $i,\n"
                           "             .xyz = {$c}, .rpy = {$c}, .axis = {$c},\n"
                           "             .lower = $n, .upper = $n},\n",
                           e->name, e->child, type[e->type], e->joint, e->xyz, 3, e->rpy, 3,
                           e->axis, 3, e->lower, e->upper);
    }
    fputs("        },\n        .joint_element = {", stream);
    for (int j = 0; j < chain->n_joints; j++)
        mukca_export_print(stream, j ? ", $i" : "$i", chain->joint_element[j]);
    fputs("},\n        .mass = {", stream);
    for (const mukca_mass *m = chain->mass; m < chain->mass + chain->n_masses; m++)
        mukca_export_print(stream, "\n            {.element = $i, .kg = $n, .com = {$c}},",
                           m->element, m->kg, m->com, 3);
    fputs(chain->n_masses ? "\n        }},\n" : "{0}}},\n", stream);
}

static void print_geometry(FILE *stream, const mukca_export_input *input)
{
    mukca_geometry geometry = {0};
    mukca_geometry_set(&geometry, input->chain, input->offsets->theta);
    fprintf(stream, "    .geometry = {.n_elements = %d, .n_joints = %d,\n        .origin = {\n",
            geometry.n_elements, geometry.n_joints);
    for (int k = 0; k < geometry.n_elements; k++)
        mukca_export_print(stream, "            {{$c},\n             {$c}},\n",
                           geometry.origin[k].R, 9, geometry.origin[k].p, 3);
    fputs("        },\n        .axis = {", stream);
    for (int k = 0; k < geometry.n_elements; k++)
        mukca_export_print(stream, k ? ", {$c}" : "{$c}", geometry.axis[k], 3);
    const int n = geometry.n_elements;
    mukca_export_print(
        stream, "},\n        .type = {$l},\n        .joint = {$l},\n        .axis_z = {$l}},\n",
        geometry.type, n, geometry.joint, n, geometry.axis_z, n);
}

static void print_applied(FILE *stream, const mukca_offsets *o)
{
    fprintf(stream, "    .n_effects = %d,\n    .effects = {", o->n_effects);
    for (const mukca_effect *e = o->effects; e < o->effects + o->n_effects; e++) {
        const mukca_effect_variant *v = &e->variant;
        fputs("\n        {.kind = MUKCA_EFFECT_", stream);
        for (const char *c = mukca_effect_table[e->kind]->name; *c; c++)
            fputc(toupper((unsigned char)*c), stream);
        mukca_export_print(stream,
                           ", .joint = $i, .placement = $i, .terms = $i,\n         .variant = "
                           "{.order = $i, .frame = $i, .neighbour = $i, .to_command = $i, "
                           ".torque_scale = $n, .time_constant = $n},\n"
                           "         .coefficient = {$c}},",
                           e->joint, e->placement, e->terms, v->order, (int)v->frame, v->neighbour,
                           v->to_command, v->torque_scale, v->time_constant, e->coefficient,
                           e->terms);
    }
    fprintf(stream, "%s},\n    .judged = %d, .accepted = %d, .intact = %d,\n",
            o->n_effects ? "\n    " : "{0}", o->acceptance.given, o->acceptance.accepted,
            o->acceptance.intact);
}

/* Print the arm as mukca_corrected_parse would construct it, for read-only memory. */
static void print_arm(FILE *stream, const char *id, const mukca_export_input *input)
{
    fprintf(stream,
            "\n#ifdef MUKCA_CORRECTED_H\n"
            "/* For libmukca_rt, where mukca/corrected.h is included before: no table is read at "
            "run time. */\nstatic const mukca_corrected %s_arm = {\n",
            id);
    print_chain(stream, input->chain);
    print_geometry(stream, input);
    print_applied(stream, input->offsets);
    fputs("};\n#endif\n", stream);
}

static mukca_status write_c(FILE *stream, const mukca_export_input *input)
{
    const mukca_chain *chain = input->chain;
    char id[MUKCA_NAME_SIZE] = "", guard[MUKCA_NAME_SIZE] = "";
    identifier(id, chain->robot);
    for (size_t i = 0; i < sizeof guard; i++) guard[i] = (char)toupper((unsigned char)id[i]);
    fputs("/* Calibrated kinematics as const arrays.\n *\n", stream);
    mukca_export_provenance(stream, " * ", input);
    print_use(stream, id);
    fprintf(stream, "#ifndef %s_KINEMATICS_H\n#define %s_KINEMATICS_H\n\n", guard, guard);
    fprintf(stream, "enum { %s_elements = %d, %s_joints = %d };\n", id, chain->n_elements, id,
            chain->n_joints);
    print_arrays(stream, id, input);
    print_arm(stream, id, input);
    fputs("\n#endif\n", stream);
    return MUKCA_OK;
}

const mukca_export_format mukca_export_c = {
    .write = write_c, .holds_all = true, .comment = {"/*", "*/"}};
