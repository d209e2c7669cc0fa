/* Comparison of two models of one arm: differences of the tip, without and with alignment of base
 * and tool. */
#include "arm/compare.h"

#include <math.h>
#include <string.h>

#include "arm/tip_change.h"
#include "math/dense.h"
#include "math/stats.h"

enum { MOST_STEPS = 50 };

/* ---- joint axes ---- */

/* At each joint the difference is the motion that brings B's axis onto A's.
 *
 * A rotation about an axis and a translation along it commute with the joint's motion.  They are
 * carried to the next joint and determined there as those that bring the next axes closest
 * together: the rotation (the joint's zero) and the translation (theta and d of Denavit and
 * Hartenberg; between parallel axes, of Hayati). */

/* Axes within this angle, rad, are treated as parallel: a translation of 8 mm, twice the largest
 * prior of a diagnosis, then changes the distance of the next axis by less than 0.2 mm, which is
 * not measurable. */
static const double parallel = 0.02;
/* Axes closer than this, m, are treated as coincident: a rotation of 20 mrad displaces the next
 * axis by 0.2 mm. */
static const double one_line = 0.01;

/* The next joints of A and B, in the frame of A's present joint. */
typedef struct {
    mukca_frame a, b;
    double axis[2][3];
    double present[3];   /* A's present axis */
    mukca_frame carried; /* B's present frame in A's: a screw along `present` */
    bool slides;         /* the next joint is prismatic: its axis has no position */
} pair;

/* Compose the links before the next joint, from element `from`; returns the joint's element. */
static int next_link(mukca_frame *link, double axis[3], const mukca_geometry *g, int from)
{
    int k = from;
    *link = g->origin[k];
    while (g->joint[k] < 0) mukca_frame_multiply(link, link, &g->origin[++k]);
    mukca_mat3_vec(axis, link->R, g->axis[k]);
    return k;
}

/* Angle about `axis` from v to w. */
static double turn_between(const double axis[3], const double v[3], const double w[3])
{
    double c[3];
    mukca_cross(c, v, w);
    return atan2(mukca_dot3(axis, c), mukca_dot3(v, w) - mukca_dot3(axis, v) * mukca_dot3(axis, w));
}

/* Component of v perpendicular to `axis`. */
static void across(double out[3], const double axis[3], const double v[3])
{
    const double along = mukca_dot3(axis, v);
    for (int i = 0; i < 3; i++) out[i] = v[i] - along * axis[i];
}

/* Rotate B about the present axis and translate it along the axis. */
static void apply(pair *p, double turn, double shift)
{
    mukca_frame screw;
    double turned[3];
    mukca_rotation_about(screw.R, p->present, turn);
    for (int i = 0; i < 3; i++) screw.p[i] = shift * p->present[i];
    mukca_frame_multiply(&p->b, &screw, &p->b);
    mukca_mat3_vec(turned, screw.R, p->axis[1]);
    memcpy(p->axis[1], turned, sizeof turned);
}

/* Move B's next axis as close to A's as the present joint permits; NaN: undetermined. */
static void fit_screw(double *turn, double *shift, pair *p)
{
    double v[3], w[3], off[3];
    across(v, p->axis[1], p->present);
    across(w, p->present, p->a.p);
    const double slope = mukca_norm3(v);
    *turn = *shift = (double)NAN;
    if (slope > parallel)
        *turn = turn_between(p->present, p->axis[1], p->axis[0]);
    else if (!p->slides && mukca_norm3(w) > one_line)
        *turn = turn_between(p->present, p->b.p, p->a.p);
    if (isfinite(*turn)) apply(p, *turn, 0);
    if (p->slides || !(slope > parallel)) return;
    for (int i = 0; i < 3; i++) off[i] = p->a.p[i] - p->b.p[i];
    across(v, p->axis[1], p->present);
    *shift = mukca_dot3(off, v) / mukca_dot3(v, v);
    apply(p, 0, *shift);
}

/* Compute and remove the difference of the axes; the remaining motion is carried on. */
static void remove_difference(mukca_axis_difference *out, pair *p)
{
    double w[3], off[3], from[3];
    for (int i = 0; i < 3; i++) from[i] = p->b.p[i] - p->a.p[i];
    across(off, p->axis[1], from);
    mukca_cross(w, p->axis[1], p->axis[0]);
    const double s = mukca_norm3(w), along = mukca_dot3(p->axis[1], from);
    out->angle = atan2(s, mukca_dot3(p->axis[1], p->axis[0]));
    out->distance = p->slides ? (double)NAN : mukca_norm3(off);
    for (int i = 0; i < 3; i++) w[i] *= s > 0 ? out->angle / s : 0;
    mukca_rotation_turn(p->b.R, w, false);
    mukca_mat3_tmul(p->carried.R, p->a.R, p->b.R);
    if (!p->slides)
        for (int i = 0; i < 3; i++) from[i] = along * p->axis[0][i];
    mukca_mat3_tvec(p->carried.p, p->a.R, from);
    mukca_mat3_tvec(p->present, p->a.R, p->axis[0]);
}

/* The joint axes, each seen from the axis before it: out[n_joints]. */
static void compare_axes(mukca_axis_difference *out, const mukca_geometry *a,
                         const mukca_geometry *b)
{
    pair p = {.carried = {.R = MUKCA_IDENTITY}};
    int at[2] = {-1, -1};
    for (int j = 0; j < a->n_joints; j++) {
        double axis[3];
        at[0] = next_link(&p.a, p.axis[0], a, at[0] + 1);
        at[1] = next_link(&p.b, axis, b, at[1] + 1);
        mukca_frame_multiply(&p.b, &p.carried, &p.b);
        mukca_mat3_vec(p.axis[1], p.carried.R, axis);
        p.slides = !mukca_joint_turns(a->type[at[0]]);
        out[j] = (mukca_axis_difference){.zero = NAN, .slide = NAN};
        if (j > 0) {
            double turn, shift;
            fit_screw(&turn, &shift, &p);
            if (j > 1) out[j - 1].zero = -turn, out[j - 1].slide = -shift;
        }
        remove_difference(&out[j], &p);
        if (j == 0) out[0].angle = 0, out[0].distance = p.slides ? (double)NAN : 0; /* base frame */
    }
}

/* ---- tips ---- */

/* Rotation of the tool: the mean of those from B's aligned tip to A's. */
static void turn_tool(mukca_comparison *c)
{
    double H[9] = {0};
    for (int i = 0; i < MUKCA_COMPARED; i++) {
        double R[9], off[9]; /* off = (base b)' a; H sums its transpose's outer products */
        mukca_mat3_mul(R, c->base.R, c->tip[1][i].R);
        mukca_mat3_tmul(off, c->tip[0][i].R, R);
        for (int k = 0; k < 9; k++) H[k] += off[k];
    }
    mukca_rotation_nearest(c->tool.R, H);
}

static mukca_compared_error sum_up(double *sorted)
{
    mukca_compared_error e = {.p95 = mukca_stats_quantile(sorted, MUKCA_COMPARED, 0.95)};
    for (int i = 0; i < MUKCA_COMPARED; i++) {
        e.mean += sorted[i] / MUKCA_COMPARED;
        e.max = fmax(e.max, sorted[i]);
    }
    return e;
}

void mukca_compare(mukca_comparison *c, const mukca_corrected *a, const mukca_corrected *b)
{
    const mukca_meeting meeting = {
        .points = c->points, .n = MUKCA_COMPARED, .base = true, .tool = true, .pull = 1e-6};
    mukca_random random = mukca_random_seeded(1);
    double R[MUKCA_MEETING_FACTOR], q[MUKCA_MAX_JOINTS];
    compare_axes(c->axis, &a->geometry, &b->geometry);
    for (int i = 0; i < MUKCA_COMPARED; i++) {
        mukca_posture_draw(q, &a->chain, &random);
        mukca_corrected_pose(&c->tip[0][i], a, q, NULL);
        mukca_corrected_pose(&c->tip[1][i], b, q, NULL);
        c->points[i] = (mukca_meeting_point){.from = c->tip[1][i], .weight = 1};
        memcpy(c->points[i].to, c->tip[0][i].p, sizeof c->points[i].to);
    }
    c->base = c->tool = (mukca_frame){.R = MUKCA_IDENTITY};
    for (int aligned = 0; aligned < 2; aligned++) {
        if (aligned) {
            mukca_frame_nearest(&c->base, c->tip[0]->p, c->tip[1]->p,
                                sizeof(mukca_frame) / sizeof(double), MUKCA_COMPARED);
            for (int i = 0; i < MOST_STEPS; i++)
                if (!(mukca_frame_refine(R, &c->base, &c->tool, &meeting) > 1e-12)) break;
            turn_tool(c);
        }
        for (int i = 0; i < MUKCA_COMPARED; i++) {
            mukca_frame at;
            mukca_frame_multiply(&at, &c->base, &c->tip[1][i]);
            mukca_frame_multiply(&at, &at, &c->tool);
            c->moved[i] = mukca_distance3(at.p, c->tip[0][i].p);
            c->turned[i] = mukca_rotation_between(at.R, c->tip[0][i].R);
        }
        c->position[aligned] = sum_up(c->moved);
        c->rotation[aligned] = sum_up(c->turned);
    }
}
