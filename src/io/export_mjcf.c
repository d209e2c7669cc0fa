/* The calibrated arm as a MuJoCo model: body poses, springs for the compliance of joints, links and
 * base, joint stops for backlash. */
#include <math.h>
#include <string.h>

#include "io/export.h"
#include "io/urdf.h"

/* Of one joint: compliance about and across its axis, rad/(N m) or m/N; backlash, rad. */
typedef struct {
    double angle, bending, play;
} elasticity;

typedef struct {
    FILE *stream;
    const mukca_chain *chain;
    elasticity joint[MUKCA_MAX_JOINTS];
    double base; /* compliance, rad/(N m) */
    int depth;   /* number of open bodies */
} writer;

static void indent(const writer *w)
{
    for (int i = 0; i < 2 * w->depth + 4; i++) fputc(' ', w->stream);
}

/* The mechanical equivalent of an effect: the sum that includes its coefficient; NULL if no spring
 * or stop behaves like it. */
static double *equivalent(writer *w, const mukca_effect *effect)
{
    const mukca_effect_site site = mukca_effect_table[effect->kind]->site;
    const int traits = mukca_effect_table[effect->kind]->traits;
    const bool elastic = traits & MUKCA_TRAIT_ELASTIC;
    if (!(effect->coefficient[0] > 0)) return NULL;
    if (site == MUKCA_SITE_BASE && elastic) return &w->base;
    if (effect->joint < 0) return NULL;
    elasticity *joint = &w->joint[effect->joint];
    if (site == MUKCA_SITE_ANGLE && (traits & MUKCA_TRAIT_PLAY)) return &joint->play;
    if (!elastic) return NULL;
    return site == MUKCA_SITE_ANGLE ? &joint->angle : &joint->bending;
}

static bool holds(const mukca_effect *effect)
{
    writer w = {0};
    return equivalent(&w, effect) != NULL;
}

/* Sum the equivalents of the effects; those without one are not among them (mukca_export_write). */
static void gather(writer *w, const mukca_offsets *offsets)
{
    for (int e = 0; e < offsets->n_effects; e++) {
        double *sum = equivalent(w, &offsets->effects[e]);
        if (sum) *sum += offsets->effects[e].coefficient[0];
    }
}

/* Print the inertial of element k, with the tensor of the URDF; where it has none, with that of a
 * solid ball of 50 mm radius.  MuJoCo refuses moving bodies without mass. */
static void print_inertial(const writer *w, int k, bool moves)
{
    mukca_mass mass = {.kg = moves ? 1e-6 : 0};
    for (int m = 0; m < w->chain->n_masses; m++)
        if (w->chain->mass[m].element == k && w->chain->mass[m].kg > 0) mass = w->chain->mass[m];
    if (!(mass.kg > 0)) return;
    const double ball = 0.4 * 0.05 * 0.05 * mass.kg; /* 2/5 m r^2 */
    if (!mukca_tensor_positive(mass.inertia)) {      /* MuJoCo refuses others */
        memset(mass.inertia + 3, 0, 3 * sizeof *mass.inertia);
        for (int i = 0; i < 3; i++) mass.inertia[i] = ball;
    }
    indent(w);
    mukca_export_print(w->stream, "<inertial pos=\"$b\" mass=\"$n\" fullinertia=\"$b\"/>\n",
                       mass.com, 3, mass.kg, mass.inertia, 6);
}

/* Open a joint: its name, type and axis (may be NULL). */
static void open_joint(const writer *w, const char *joint, const char *suffix, const char *type,
                       const double *axis)
{
    indent(w);
    mukca_export_print(w->stream, "<joint name=\"$x$s\" type=\"$s\"", joint, suffix, type);
    if (axis) mukca_export_print(w->stream, " axis=\"$b\"", axis, 3);
}

/* Print a spring of that compliance.  The time constant of its creep, damping / stiffness, is 20
 * ms: the arm settles within a second without oscillation. */
static void print_spring(const writer *w, double compliance)
{
    const double stiffness = 1 / compliance, damping = 2e-2 * stiffness;
    mukca_export_print(w->stream, " stiffness=\"$n\" damping=\"$n\"/>\n", stiffness, damping);
}

/* Print the link's bending about two axes across the joint, the joint itself, and its
 * transmission. */
static void print_joints(const writer *w, const mukca_element *e)
{
    const elasticity *g = &w->joint[e->joint];
    const char *type = e->type == MUKCA_PRISMATIC ? "slide" : "hinge";
    double across[2][3];
    mukca_rotation_transverse(across[0], across[1], e->axis);
    for (int i = 0; i < 2 && g->bending > 0; i++) {
        open_joint(w, e->name, i ? "_bend_2" : "_bend_1", "hinge", across[i]);
        print_spring(w, g->bending);
    }
    open_joint(w, e->name, "", type, e->axis);
    if (isfinite(e->lower) && isfinite(e->upper))
        mukca_export_print(w->stream, " range=\"$n $n\"", e->lower, e->upper);
    /* rough rotor inertia, kg m^2: separates the motor from the link on its spring */
    fputs(g->angle > 0 || g->play > 0 ? " armature=\"0.1\"/>\n" : "/>\n", w->stream);
    if (g->angle > 0) {
        open_joint(w, e->name, "_flex", type, e->axis);
        print_spring(w, g->angle);
    }
    if (g->play > 0) {
        open_joint(w, e->name, "_play", type, e->axis);
        mukca_export_print(
            w->stream,
            " range=\"$n $n\" armature=\"0.1\" damping=\"1\" solreflimit=\"0.005 1\" "
            "solimplimit=\"0.99 0.999 1e-4\"/>\n",
            -0.5 * g->play, 0.5 * g->play);
    }
}

static void open_body(writer *w, const char *link, const double *pos, const double *quat)
{
    indent(w);
    mukca_export_print(w->stream, "<body name=\"$x\"", link);
    if (pos) mukca_export_print(w->stream, " pos=\"$b\" quat=\"$b\"", pos, 3, quat, 4);
    fputs(">\n", w->stream);
    w->depth++;
}

static mukca_status write_mjcf(FILE *stream, const mukca_export_input *input)
{
    const mukca_chain *chain = input->chain;
    writer w = {.stream = stream, .chain = chain};
    fputs("<!--\n", stream);
    mukca_export_provenance(stream, "     ", input);
    fputs(
        "     A statics model: bodies and joints have the URDF's names; pos and quat are the\n"
        "     calibrated origins.  Springs (_flex, _bend, base_flex) and stops (_play) represent\n"
        "     the identified effects; inertia tensors are the URDF's.\n",
        stream);
    gather(&w, input->offsets);
    mukca_export_print(
        stream,
        "-->\n<mujoco model=\"$x\">\n"
        "  <compiler angle=\"radian\" autolimits=\"true\" balanceinertia=\"true\"/>\n"
        "  <option gravity=\"$b\" timestep=\"5e-4\" integrator=\"implicitfast\"/>\n  <worldbody>\n",
        chain->robot, chain->gravity, 3);
    open_body(&w, chain->base, NULL, NULL);
    if (w.base > 0) {
        open_body(&w, "base_flex", NULL, NULL);
        open_joint(&w, "base_flex", "", "ball", NULL);
        print_spring(&w, w.base);
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
