/* The calibrated arm as a MuJoCo model: poses of bodies; springs for the compliance of joints,
 * links and base; stops for backlash. */
#include <math.h>
#include <string.h>

#include "io/export.h"

/* Of one joint: compliance about its axis and across it, rad/(N m) or m/N, and backlash, rad. */
typedef struct {
    double angle, bending, play;
} elasticity;

typedef struct {
    FILE *stream;
    const mukca_export_input *input;
    const mukca_chain *chain;
    elasticity joint[MUKCA_MAX_JOINTS];
    double base; /* compliance, rad/(N m) */
    int depth;   /* of open bodies */
} writer;

static void indent(const writer *w)
{
    for (int i = 0; i < 2 * w->depth + 4; i++) fputc(' ', w->stream);
}

static void numbers(const writer *w, const char *key, const double *values, int n)
{
    fprintf(w->stream, " %s=\"", key);
    mukca_export_numbers(w->stream, values, n, " ");
    fputc('"', w->stream);
}

/* An attribute, escaped as XML requires. */
static void name(const writer *w, const char *key, const char *text, const char *suffix)
{
    fprintf(w->stream, " %s=\"", key);
    for (; *text; text++) {
        const char *escaped = *text == '&' ? "&amp;" : *text == '<' ? "&lt;" : "&quot;";
        if (strchr("&<\"", *text))
            fputs(escaped, w->stream);
        else
            fputc((unsigned char)*text < ' ' ? ' ' : *text, w->stream);
    }
    fprintf(w->stream, "%s\"", suffix);
}

/* The mechanical equivalent of an effect: the sum that its coefficient adds to, NULL where no
 * spring or stop behaves like it. */
static double *equivalent(writer *w, const mukca_effect *effect)
{
    elasticity *joint = effect->joint < 0 ? NULL : &w->joint[effect->joint];
    const mukca_effect_site site = mukca_effect_table[effect->kind]->site;
    const int traits = mukca_effect_table[effect->kind]->traits;
    if (!(effect->coefficient[0] > 0)) return NULL;
    if (traits & MUKCA_TRAIT_PLAY) return &joint->play;
    if (!(traits & MUKCA_TRAIT_ELASTIC)) return NULL;
    return site == MUKCA_SITE_BASE    ? &w->base
           : site == MUKCA_SITE_ANGLE ? &joint->angle
                                      : &joint->bending;
}

static bool holds(const mukca_effect *effect)
{
    writer w = {0};
    return equivalent(&w, effect) != NULL;
}

/* Sum the equivalents; a line of the comment for each effect that has none. */
static void gather(writer *w)
{
    const mukca_offsets *o = w->input->offsets;
    for (int e = 0; e < o->n_effects; e++) {
        double *sum = equivalent(w, &o->effects[e]);
        const char *joint = mukca_export_joint(w->input, &o->effects[e]);
        if (sum)
            *sum += o->effects[e].coefficient[0];
        else
            fprintf(w->stream, "     Left out, no spring or stop behaves like it: %s of %s\n",
                    mukca_effect_table[o->effects[e].kind]->name, joint ? joint : "the arm");
    }
}

/* Mass, centre and a rough inertia of what hangs on element k: each mass a ball of 50 mm radius,
 * which matters for the time to come to rest only.  MuJoCo refuses moving bodies without mass. */
static void print_inertial(const writer *w, int k, bool moves)
{
    double kg = 0, com[3] = {0, 0, 0}, inertia = 0;
    for (int m = 0; m < w->chain->n_masses; m++) {
        const mukca_mass *mass = &w->chain->mass[m];
        if (mass->element != k) continue;
        kg += mass->kg;
        for (int i = 0; i < 3; i++) com[i] += mass->kg * mass->com[i];
    }
    for (int i = 0; i < 3 && kg > 0; i++) com[i] /= kg;
    for (int m = 0; m < w->chain->n_masses; m++) {
        const mukca_mass *mass = &w->chain->mass[m];
        if (mass->element != k) continue;
        double square = 0.4 * 0.05 * 0.05; /* 2/5 r^2, a solid ball */
        for (int i = 0; i < 3; i++) square += (mass->com[i] - com[i]) * (mass->com[i] - com[i]);
        inertia += mass->kg * square;
    }
    if (!(kg > 0)) {
        if (!moves) return;
        kg = 1e-6;
        inertia = 1e-9;
    }
    const double diagonal[3] = {inertia, inertia, inertia};
    indent(w);
    fputs("<inertial", w->stream);
    numbers(w, "pos", com, 3);
    numbers(w, "mass", &kg, 1);
    numbers(w, "diaginertia", diagonal, 3);
    fputs("/>\n", w->stream);
}

/* A spring of that compliance.  Damping / stiffness is the time constant of its creep, 20 ms: the
 * arm comes to rest within a second, and no link oscillates. */
static void print_spring(const writer *w, const char *joint, const char *suffix, const char *type,
                         const double axis[3], double compliance)
{
    const double stiffness = 1 / compliance, damping = 2e-2 * stiffness;
    indent(w);
    fputs("<joint", w->stream);
    name(w, "name", joint, suffix);
    fprintf(w->stream, " type=\"%s\"", type);
    if (axis) numbers(w, "axis", axis, 3);
    numbers(w, "stiffness", &stiffness, 1);
    numbers(w, "damping", &damping, 1);
    fputs("/>\n", w->stream);
}

/* The link's bending about two axes across the joint, the joint itself, and its transmission. */
static void print_joints(const writer *w, const mukca_element *e)
{
    const elasticity *g = &w->joint[e->joint];
    const char *type = e->type == MUKCA_PRISMATIC ? "slide" : "hinge";
    double e1[3], e2[3];
    if (g->bending > 0) {
        mukca_rotation_transverse(e1, e2, e->axis);
        print_spring(w, e->name, "_bend_1", "hinge", e1, g->bending);
        print_spring(w, e->name, "_bend_2", "hinge", e2, g->bending);
    }
    indent(w);
    fputs("<joint", w->stream);
    name(w, "name", e->name, "");
    fprintf(w->stream, " type=\"%s\"", type);
    numbers(w, "axis", e->axis, 3);
    if (isfinite(e->lower) && isfinite(e->upper)) {
        const double range[2] = {e->lower, e->upper};
        numbers(w, "range", range, 2);
    }
    /* the rotor's inertia, kg m^2 (rough): separates the motor's side of a spring from the link's
     */
    fputs(g->angle > 0 || g->play > 0 ? " armature=\"0.1\"/>\n" : "/>\n", w->stream);
    if (g->angle > 0) print_spring(w, e->name, "_flex", type, e->axis, g->angle);
    if (g->play > 0) {
        const double range[2] = {-0.5 * g->play, 0.5 * g->play};
        indent(w);
        fputs("<joint", w->stream);
        name(w, "name", e->name, "_play");
        fprintf(w->stream, " type=\"%s\"", type);
        numbers(w, "axis", e->axis, 3);
        numbers(w, "range", range, 2);
        fputs(
            " armature=\"0.1\" damping=\"1\" solreflimit=\"0.005 1\" solimplimit=\"0.99 0.999 "
            "1e-4\"/>\n",
            w->stream);
    }
}

static void open_body(writer *w, const char *link, const double *pos, const double *quat)
{
    indent(w);
    fputs("<body", w->stream);
    name(w, "name", link, "");
    if (pos) numbers(w, "pos", pos, 3);
    if (quat) numbers(w, "quat", quat, 4);
    fputs(">\n", w->stream);
    w->depth++;
}

static mukca_status write_mjcf(FILE *stream, const mukca_export_input *input, mukca_error *error)
{
    const mukca_chain *chain = input->chain;
    writer w = {.stream = stream, .input = input, .chain = chain};
    (void)error;
    fputs("<!--\n", stream);
    mukca_export_provenance(stream, "     ", input);
    fputs(
        "     A statics model: bodies and joints have the URDF's names; pos and quat hold the\n"
        "     calibrated origins.  Springs (_flex, _bend, base_flex) and stops (_play) stand for\n"
        "     found effects; inertias are rough, take your own.\n",
        stream);
    gather(&w);
    fputs("-->\n<mujoco", stream);
    name(&w, "model", chain->robot, "");
    fputs(">\n  <compiler angle=\"radian\" autolimits=\"true\"/>\n  <option", stream);
    numbers(&w, "gravity", chain->gravity, 3);
    fputs(" timestep=\"5e-4\" integrator=\"implicitfast\"/>\n  <worldbody>\n", stream);
    open_body(&w, chain->base, NULL, NULL);
    if (w.base > 0) {
        open_body(&w, "base_flex", NULL, NULL);
        print_spring(&w, "base_flex", "", "ball", NULL, w.base);
        print_inertial(&w, -2, true);
    }
    for (int k = 0; k < chain->n_elements; k++) {
        const mukca_element *e = &chain->element[k];
        mukca_export_origin origin;
        mukca_export_get_origin(&origin, input, k);
        open_body(&w, e->child, origin.xyz, origin.quaternion);
        if (e->joint >= 0) print_joints(&w, e);
        print_inertial(&w, k, e->joint >= 0);
    }
    indent(&w);
    fputs("<site name=\"tip\"/>\n", stream);
    while (w.depth > 0) {
        w.depth--;
        indent(&w);
        fputs("</body>\n", stream);
    }
    fputs("  </worldbody>\n</mujoco>\n", stream);
    return MUKCA_OK;
}

const mukca_export_format mukca_export_mjcf = {.write = write_mjcf, .holds = holds};
