/* Jacobian of the corrected arm: the equilibrium under load moves with the joints' angles.
 *
 * From the tip backwards, all rows of the Jacobian side by side.  A motion that moves the tip by J
 * where nothing answers, and brings M and N of equilibrium.h about, moves it by
 * J + by_M . M + by_N . N in all: what yields further in answers M, what yields further out N.
 * These sums hold what the answers do to the tip, which is found in the same way.  Of by_N that
 * begins with all answers, nothing is left in the end: three more rows, which begin with one unit
 * each, show what to begin with, as all of this is linear.
 */
#include "arm/corrected_jacobian.h"

#include <string.h>

/* Rows of the Jacobian, then those of the units; UNIT(i, row): 1 in row i, else 0, from `row` on.
 * With several lanes up to whole vectors, which hide each other's latency side by side. */
#if MUKCA_LANES > 1
enum { UNITS = 6, ALL_ROWS = 12, BESIDE = 3 };
static const double unit_row[9 + ALL_ROWS] = {[9] = 1};
#define UNIT(i, row) LOAD_LANES(unit_row + 9 - (i) + (row))
#else
enum { UNITS = 6, ALL_ROWS = 9, BESIDE = 1 };
#define UNIT(i, row) ((i) == (row))
#endif
#define DOT(a, b) ((a)[0] * (b)[0] + (a)[1] * (b)[1] + (a)[2] * (b)[2])

typedef struct {
    LANES_ALIGNED double row[ALL_ROWS];
} column;

/* The arm, how the base answers, and the sweep's results. */
typedef struct {
    LANES_ALIGNED columns base;     /* to motions of the tip */
    column joint[MUKCA_MAX_JOINTS]; /* as it turns where nothing answers; then the derivative */
    column left[3];                 /* of by_N */
    double closed[3][3];            /* the base: to its own motions */
    const mukca_equilibrium *e;
    const mukca_effect_slopes *slopes;
} tip_columns;

/* What the answers do to the tip, as sums; and the joint before to this one's column. */
typedef struct {
    LANES_ALIGNED lanes by_M[3], by_N[3], before;
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
PART void apply(lanes v[3], const columns *K)
{
    const lanes x = v[0], y = v[1], z = v[2];
    for (int i = 0; i < 3; i++)
        v[i] = COLUMN(K, 0, i) * x + COLUMN(K, 1, i) * y + COLUMN(K, 2, i) * z;
}

/* v := m v, by rows */
PART void multiply(lanes v[3], const double m[3][3])
{
    const lanes of[3] = {v[0], v[1], v[2]};
    for (int i = 0; i < 3; i++) v[i] = DOT(of, m[i]);
}

/* inverse, by rows := that of the matrix with these columns. */
PART void invert(double inverse[3][3], const double of[3][3])
{
    for (int i = 0; i < 3; i++) mukca_cross(inverse[i], of[(i + 1) % 3], of[(i + 2) % 3]);
    const double size = 1 / mukca_dot3(inverse[0], of[0]);
    for (int k = 0; k < 9; k++) inverse[k / 3][k % 3] *= size;
}

/* What the base's motion b becomes with the answers K to it: as it turns, by_M is b x g. */
PART void close_base(double closed[3][3], const columns *K, const mukca_equilibrium *e)
{
    double own[3][3], of_row[MUKCA_LANES];
    for (int row = 0; row < 3; row += MUKCA_LANES) {
        const lanes unit[3] = {UNIT(0, row), UNIT(1, row), UNIT(2, row)};
        lanes by_M[3] = {0}, v[3] = {0};
        add_cross(by_M, unit, XYZ(e->gravity));
        add_cross(v, by_M, XYZ(e->first));
        apply(v, K);
        for (int i = 0; i < 3; i++) {
            v[i] += unit[i];
            memcpy(of_row, &v[i], sizeof of_row);
            for (int r = 0; r < MUKCA_LANES && row + r < 3; r++) own[row + r][i] = of_row[r];
        }
    }
    invert(closed, (const double(*)[3])own);
}

/* Rotation vectors of joints that tilt in base coordinates, the slopes' as angular velocities; the
 * frames of joints that bend become their answers.  Under moments that are given nothing answers.
 */
static void prepare(tip_columns *c, mukca_equilibrium *e, mukca_effect_slopes *slopes)
{
    if (!e->loaded) e->bend = 0;
    if (e->bend != 0) {
        set_answer(&c->base, e->displacement.base, 1, e->bend, NULL);
        close_base(c->closed, &c->base, e);
    }
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

/* Columns of the joints where nothing answers. */
PART void set_columns(column *joint, const mukca_equilibrium *e)
{
    const double *tip = XYZ(e->tip.column[3]);
    for (int j = 0; j < e->n_joints; j++) {
        const mukca_joint_posture *at = &e->joint[j];
        const double *axis = XYZ(at->axis), *p = XYZ(at->frame.column[3]);
        const double d[3] = {tip[0] - p[0], tip[1] - p[1], tip[2] - p[2]};
        memset(joint[j].row, 0, sizeof joint[j].row);
        memcpy(joint[j].row + (at->slides ? 0 : 3), axis, 3 * sizeof *axis);
        if (!at->slides) mukca_cross(joint[j].row, axis, d);
    }
}

/* Nothing but units of by_N, and the base's answer. */
PART void pass_base(tip_answers *t, const tip_columns *c, int row)
{
    const mukca_equilibrium *e = c->e;
    const double *g = XYZ(e->gravity);
    lanes base[3];
    t->before = (lanes){0};
    for (int i = 0; i < 3; i++) t->by_M[i] = (lanes){0}, t->by_N[i] = UNIT(UNITS + i, row);
    if (e->bend == 0) return;
    turn_frame(base, t, g, row, XYZ(e->tip.column[3]), XYZ(e->first));
    apply(base, &c->base);
    multiply(base, c->closed);
    add_cross(t->by_M, base, g);
}

/* What the joint answers becomes part of by_M, and no longer of by_N; what it does to the tip is
 * shared out to its column and its neighbours'. */
PART void pass_joint(tip_answers *t, tip_columns *c, int j, int row)
{
    const mukca_equilibrium *e = c->e;
    const mukca_joint_posture *at = &e->joint[j];
    const double *M = XYZ(at->into_M), *N = XYZ(at->into_N), *p = XYZ(at->frame.column[3]);
    const double *g = XYZ(e->gravity), *tip = XYZ(e->tip.column[3]), *by = c->slopes->angle[j];
    double *own = c->joint[j].row + row;
    lanes rate = t->before;
    if (at->turns || at->bend != 0) {
        const double d[3] = {tip[0] - p[0], tip[1] - p[1], tip[2] - p[2]};
        lanes frame[3];
        turn_frame(frame, t, g, row, d, XYZ(at->first));
        if (at->turns) rate += DOT(frame, c->slopes->rotation[j]);
        if (at->bend != 0) {
            apply(frame, &at->frame);
            add_cross(t->by_M, frame, g);
            take_cross(t->by_N, frame, XYZ(at->first));
        }
    }
    const lanes turn = LOAD_LANES(own) + DOT(t->by_M, M) + DOT(t->by_N, N);
    for (int i = 0; i < 3 && at->yields; i++) {
        t->by_M[i] += at->twist * N[i] * turn;
        t->by_N[i] -= at->twist * M[i] * turn;
    }
    STORE_LANES(own, rate + by[1] * turn);
    t->before = by[2] * turn;
    if (j == 0) return;
    own = c->joint[j - 1].row + row;
    STORE_LANES(own, LOAD_LANES(own) + by[0] * turn);
}

MUKCA_CLONES void mukca_corrected_differentiate(double *J, mukca_equilibrium *e,
                                                mukca_effect_slopes *slopes)
{
    const int n = e->n_joints, rows = e->loaded ? UNITS + 3 : UNITS;
    double left[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, begin[3][3];
    tip_columns c;
    c.e = e;
    c.slopes = slopes;
    prepare(&c, e, slopes);
    set_columns(c.joint, e);
    for (int row = 0; row < rows; row += BESIDE * MUKCA_LANES) {
        tip_answers t[BESIDE];
        for (int b = 0; b < BESIDE; b++) pass_base(&t[b], &c, row + MUKCA_LANES * b);
        for (int j = 0; j < n; j++)
            for (int b = 0; b < BESIDE; b++) pass_joint(&t[b], &c, j, row + MUKCA_LANES * b);
        for (int i = 0; i < 3; i++)
            for (int b = 0; b < BESIDE; b++)
                STORE_LANES(c.left[i].row + row + MUKCA_LANES * b, t[b].by_N[i]);
    }
    for (int k = 0; k < 9 && e->loaded; k++) left[k / 3][k % 3] = c.left[k % 3].row[UNITS + k / 3];
    invert(begin, (const double(*)[3])left);
    for (int row = 0; row < UNITS; row += MUKCA_LANES) {
        lanes x[3];
        double of_row[MUKCA_LANES];
        for (int i = 0; i < 3; i++) x[i] = LOAD_LANES(c.left[i].row + row);
        multiply(x, (const double(*)[3])begin);
        for (int j = 0; j < n; j++) {
            const double *unit = c.joint[j].row + UNITS;
            const lanes rate = LOAD_LANES(c.joint[j].row + row) - DOT(x, unit);
            memcpy(of_row, &rate, sizeof of_row);
            for (int r = 0; r < MUKCA_LANES && row + r < UNITS; r++)
                J[(row + r) * n + j] = of_row[r];
        }
    }
}
