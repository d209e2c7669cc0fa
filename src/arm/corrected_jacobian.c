/* Jacobian of the corrected arm: the equilibrium under load moves with the joints' angles.
 *
 * From the tip backwards, all rows of the Jacobian side by side.  A motion that moves the tip by J
 * where nothing answers, and brings M and N of equilibrium.h about, moves it by
 * J + by_M . M + by_N . N in all: what yields further in answers M, what yields further out N.
 * These sums hold what the answers do to the tip, which is found in the same way: a fixed point.
 */
#include "arm/corrected_jacobian.h"

#include <string.h>

/* Vectors of rows side by side, which hide each other's latency, and numbers of a column. */
#if MUKCA_LANES > 1
enum { BESIDE = 2, COLUMN_ROWS = 8 };
#else
enum { BESIDE = 1, COLUMN_ROWS = 6 };
#endif
#define DOT(a, b) ((a)[0] * (b)[0] + (a)[1] * (b)[1] + (a)[2] * (b)[2])

/* UNIT(i, row): 1 in row i, else 0, from `row` on. */
static const double unit_row[6 + 8] = {[6] = 1};
#define UNIT(i, row) LOAD_LANES(unit_row + 6 - (i) + (row))

typedef struct {
    LANES_ALIGNED double row[COLUMN_ROWS];
} column;

/* Columns of joints as they turn, and as what their effects add turns with them, at `rate`. */
typedef struct {
    column turn[MUKCA_MAX_JOINTS], tilt[MUKCA_MAX_JOINTS];
    const double (*rate)[3];
    LANES_ALIGNED columns base; /* its answer */
} tip_columns;

/* What the answers do to the tip: of the base by 1 N m, as part of by_M, and the sums. */
typedef struct {
    LANES_ALIGNED lanes base[3], by_M[3], by_N[3];
} tip_answers;

/* c += a x b; c -= a x b */
PART void add_cross(lanes c[3], const lanes a[3], const double b[3])
{
    c[0] += a[1] * b[2] - a[2] * b[1];
    c[1] += a[2] * b[0] - a[0] * b[2];
    c[2] += a[0] * b[1] - a[1] * b[0];
}

PART void take_cross(lanes c[3], const lanes a[3], const double b[3])
{
    c[0] -= a[1] * b[2] - a[2] * b[1];
    c[1] -= a[2] * b[0] - a[0] * b[2];
    c[2] -= a[0] * b[1] - a[1] * b[0];
}

/* (1 - b w.w) + b w w' + a [w]x: angular velocity of exp([w]x) by the rate of w, in the coordinates
 * before (side 1) or after (-1) that rotation, the left and right Jacobian of SO(3).  The series is
 * exact to 1e-9 up to |w| = 0.2 rad. */
typedef struct {
    double a, b, t2;
} velocity;

static velocity velocity_at(const double w[3], double side)
{
    const double t2 = mukca_dot3(w, w);
    return (velocity){.a = side * (0.5 - t2 * (1.0 / 24 - t2 * (1.0 / 720))),
                      .b = 1.0 / 6 - t2 * (1.0 / 120 - t2 * (1.0 / 5040)),
                      .t2 = t2};
}

/* K := what a frame with the rotation vector w makes of the tip's motion by rotations: that by
 * moments, with the slope of the rotation by the moment (across the axis).  By columns. */
static void set_answer(columns *K, const double w[3], double side, double slope, const double *axis)
{
    const velocity v = velocity_at(w, side);
    for (int k = 0; k < 3; k++) {
        const double along = v.b * w[k], unit[3] = {k == 0, k == 1, k == 2};
        double m[3], off = 0;
        mukca_cross(m, unit, w);
        for (int i = 0; i < 3; i++)
            m[i] = slope * (v.a * m[i] + along * w[i] + (1 - v.b * v.t2) * unit[i]);
        if (axis) off = mukca_dot3(axis, m);
        for (int i = 0; i < 3; i++)
            ((double *)K->column[k])[i] = axis ? m[i] - off * axis[i] : m[i];
    }
}

/* Rotation vectors of joints that tilt in base coordinates, the slopes' as angular velocities; the
 * frames of joints that bend become their answers.  Under moments that are given nothing answers.
 */
static void prepare(columns *base, mukca_equilibrium *e, mukca_effect_slopes *slopes)
{
    if (!e->loaded) e->bend = 0;
    if (e->bend != 0) set_answer(base, e->displacement.base, 1, e->bend, NULL);
    for (int j = 0; j < e->n_joints; j++) {
        mukca_joint_posture *at = &e->joint[j];
        double *rate = slopes->rotation[j], *w = e->displacement.rotation[j], across[3];
        if (!e->loaded) at->twist = at->bend = 0;
        at->turns = rate[0] != 0 || rate[1] != 0 || rate[2] != 0;
        if (!at->turns && at->bend == 0) continue;
        to_base(w, &at->frame, w);
        if (at->turns) {
            to_base(rate, &at->frame, rate);
            const velocity v = velocity_at(w, -1);
            const double along = v.b * mukca_dot3(w, rate);
            mukca_cross(across, w, rate);
            for (int i = 0; i < 3; i++)
                rate[i] = (1 - v.b * v.t2) * rate[i] + along * w[i] + v.a * across[i];
        }
        if (at->bend != 0) set_answer(&at->frame, w, -1, at->bend, XYZ(at->axis));
    }
}

/* out[3] := rows of the tip's motion by rotations about x, y and z, where the tip is at d from what
 * turns, which has the first moment S. */
PART void turn_frame(lanes out[3], const tip_answers *t, const double g[3], int row,
                     const double d[3], const double S[3])
{
    const lanes shift[3] = {UNIT(0, row), UNIT(1, row), UNIT(2, row)};
    for (int i = 0; i < 3; i++) out[i] = UNIT(3 + i, row);
    take_cross(out, shift, d);
    take_cross(out, t->by_M, S);
    take_cross(out, t->by_N, g);
}

/* v := K v */
PART void apply_answer(lanes v[3], const columns *K)
{
    const lanes x = v[0], y = v[1], z = v[2];
    for (int i = 0; i < 3; i++)
        v[i] = COLUMN(K, 0, i) * x + COLUMN(K, 1, i) * y + COLUMN(K, 2, i) * z;
}

/* Columns of the joints where nothing answers. */
PART void set_columns(column *turn, const mukca_equilibrium *e)
{
    const double *tip = XYZ(e->tip.column[3]);
    for (int j = 0; j < e->n_joints; j++) {
        const mukca_joint_posture *at = &e->joint[j];
        const double *axis = XYZ(at->axis), *p = XYZ(at->frame.column[3]);
        const double d[3] = {tip[0] - p[0], tip[1] - p[1], tip[2] - p[2]};
        memset(turn[j].row, 0, sizeof turn[j].row);
        memcpy(turn[j].row + (at->slides ? 0 : 3), axis, 3 * sizeof *axis);
        if (!at->slides) mukca_cross(turn[j].row, axis, d);
    }
}

/* The base's answer as part of by_M. */
PART void pass_base(tip_answers *t, const tip_columns *c, const mukca_equilibrium *e, int row,
                    bool last)
{
    const double *g = XYZ(e->gravity);
    for (int i = 0; i < 3; i++) t->by_M[i] = (lanes){0};
    if (e->bend == 0) return;
    add_cross(t->by_M, t->base, g);
    if (last) return;
    turn_frame(t->base, t, g, row, XYZ(e->tip.column[3]), XYZ(e->first));
    apply_answer(t->base, &c->base);
    for (int i = 0; i < 3; i++) t->by_M[i] = (lanes){0};
    add_cross(t->by_M, t->base, g);
}

/* What the joint answers becomes part of by_M, and no longer of by_N.  `last`: its columns get what
 * the answers add. */
PART void pass_joint(tip_answers *t, tip_columns *c, const mukca_equilibrium *e, int j, int row,
                     bool last)
{
    const mukca_joint_posture *at = &e->joint[j];
    const double *M = XYZ(at->into_M), *N = XYZ(at->into_N), *p = XYZ(at->frame.column[3]);
    const double *g = XYZ(e->gravity), *tip = XYZ(e->tip.column[3]);
    const bool turns = last && at->turns;
    if (turns || at->bend != 0) {
        const double d[3] = {tip[0] - p[0], tip[1] - p[1], tip[2] - p[2]};
        lanes frame[3];
        turn_frame(frame, t, g, row, d, XYZ(at->first));
        if (turns) STORE_LANES(c->tilt[j].row + row, DOT(frame, c->rate[j]));
        if (at->bend != 0) {
            apply_answer(frame, &at->frame);
            add_cross(t->by_M, frame, g);
            take_cross(t->by_N, frame, XYZ(at->first));
        }
    }
    if (!last && !at->yields) return;
    const lanes turn = LOAD_LANES(c->turn[j].row + row) + DOT(t->by_M, M) + DOT(t->by_N, N);
    if (last) STORE_LANES(c->turn[j].row + row, turn);
    for (int i = 0; i < 3 && at->yields; i++) {
        t->by_M[i] += at->twist * N[i] * turn;
        t->by_N[i] -= at->twist * M[i] * turn;
    }
}

/* Outwards over the joints; in the end nothing should be left of by_N. */
PART void sweep(tip_answers t[BESIDE], tip_columns *c, const mukca_equilibrium *e, int row,
                bool last)
{
    for (int b = 0; b < BESIDE; b++) pass_base(&t[b], c, e, row + MUKCA_LANES * b, last);
    for (int j = 0; j < e->n_joints; j++)
        for (int b = 0; b < BESIDE; b++) pass_joint(&t[b], c, e, j, row + MUKCA_LANES * b, last);
}

/* by_N of all answers: what is left of it in the end is too much in the beginning, up to what is
 * left of that in turn. */
PART void settle(tip_answers t[BESIDE], tip_columns *c, const mukca_equilibrium *e, int row)
{
    enum { ROUNDS = 8 };
    lanes all[BESIDE][3];
    double size = 0;
    for (int b = 0; b < BESIDE; b++)
        for (int i = 0; i < 3; i++) t[b].base[i] = all[b][i] = (lanes){0};
    for (int round = 0; round < ROUNDS && e->loaded; round++) {
        const double before = size;
        lanes squares = {0};
        double of_row[MUKCA_LANES];
        for (int b = 0; b < BESIDE; b++)
            for (int i = 0; i < 3; i++) t[b].by_N[i] = all[b][i];
        sweep(t, c, e, row, false);
        for (int b = 0; b < BESIDE; b++)
            for (int i = 0; i < 3; i++) {
                squares += t[b].by_N[i] * t[b].by_N[i];
                all[b][i] -= t[b].by_N[i];
            }
        memcpy(of_row, &squares, sizeof of_row);
        size = 0;
        for (int r = 0; r < MUKCA_LANES; r++) size += of_row[r];
        /* The next change is smaller than this at least as this than the one before, which the
         * first two alone would show badly: g times three times that within 1e-12. */
        if (round > 1 && !(size * size > 1e-27 * before)) break;
    }
    for (int b = 0; b < BESIDE; b++)
        for (int i = 0; i < 3; i++) t[b].by_N[i] = all[b][i];
}

MUKCA_CLONES void mukca_corrected_differentiate(double *J, mukca_equilibrium *e,
                                                mukca_effect_slopes *slopes)
{
    const int n = e->n_joints;
    tip_columns c;
    tip_answers t[BESIDE];
    c.rate = (const double(*)[3])slopes->rotation;
    prepare(&c.base, e, slopes);
    set_columns(c.turn, e);
    for (int row = 0; row < 6; row += BESIDE * MUKCA_LANES) {
        settle(t, &c, e, row);
        sweep(t, &c, e, row, true);
        for (int l = 0; l < n; l++)
            for (int b = row; b < 6 && b < row + BESIDE * MUKCA_LANES; b += MUKCA_LANES) {
                lanes rate = slopes->angle[l][1] * LOAD_LANES(c.turn[l].row + b);
                if (e->joint[l].turns) rate += LOAD_LANES(c.tilt[l].row + b);
                if (l > 0) rate += slopes->angle[l - 1][2] * LOAD_LANES(c.turn[l - 1].row + b);
                if (l + 1 < n) rate += slopes->angle[l + 1][0] * LOAD_LANES(c.turn[l + 1].row + b);
                double of_row[MUKCA_LANES];
                memcpy(of_row, &rate, sizeof of_row);
                for (int r = 0; r < MUKCA_LANES && b + r < 6; r++) J[(b + r) * n + l] = of_row[r];
            }
    }
}
