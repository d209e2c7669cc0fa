/* Jacobian of the corrected arm: derivative of the static equilibrium by the joint angles; response
 * to a change of load.
 *
 * From base to tip, all rows of the Jacobian in parallel.  If a motion moves the tip of a rigid arm
 * by J, with M and N of equilibrium.h, the tip of the elastic arm moves by J + by_M . M + by_N . N:
 * the proximal joints respond to M, the distal ones to N.  A response is itself such a motion,
 * and its share of by_M and by_N follows from its J, M and N.  N = W x g is perpendicular to
 * gravity g, and so is by_M, as M acts through g x M: two components each if z is along gravity.
 * Each joint passed moves its share from by_N to by_M; by_N ends at 0.  The initial by_N is
 * unknown, but the recursion is linear: it starts at 0, two more rows start at one unit each, and a
 * 2 x 2 system at the end yields the multiples of these for which by_N ends at 0.
 */
#include "effect/equilibrium.h"

#include <string.h>

/* Eight rows: three of the tip's linear motion, one that starts at by_N = (1, 0), three of the
 * angular motion, one that starts at (0, 1). */
enum { ALL = 8 / MUKCA_LANES, UNIT = 3 };
typedef struct {
    LANES_ALIGNED lanes row[ALL];
} rows;

/* Response of the tip to M and N; contribution of the previous joint to the present column. */
typedef struct {
    rows by_M[2], by_N[2], before;
} tip_response;

/* The posture in the level frame, with gravity `g` along its z axis, and all columns of the
 * Jacobian: first of the rigid arm, finally of the corrected arm. */
typedef struct {
    columns level;
    rows joint[MUKCA_MAX_JOINTS];
    double g;
    const mukca_equilibrium *e;
    const mukca_effect_slopes *slopes;
} tip_columns;

/* v := (1 - b w.w) v + b (w . v) w + a w x v: from the rate v of a rotation vector w to the angular
 * velocity of exp([w]x), in coordinates before (side 1) or after (-1) that rotation: left and right
 * Jacobian of SO(3), each the transpose of the other.  The series is exact to 1e-9 up to
 * |w| = 0.2 rad. */
PART void turn_rate(double v[3], const double w[3], double side)
{
    const double t2 = mukca_dot3(w, w);
    const double a = side * (0.5 - t2 * (1.0 / 24 - t2 * (1.0 / 720)));
    const double b = 1.0 / 6 - t2 * (1.0 / 120 - t2 * (1.0 / 5040));
    const double along = b * mukca_dot3(w, v);
    double across[3];
    mukca_cross(across, w, v);
    for (int i = 0; i < 3; i++) v[i] = (1 - b * t2) * v[i] + along * w[i] + a * across[i];
}

/* K := matrix from the tip's motion per rotation of a frame, in coordinates after (side 1) or
 * before (-1) its rotation vector w, to that per moment; `slope`: derivative of w by the moment
 * (across the axis).  By columns. */
PART void set_compliance(columns *K, const double w[3], double side, double slope,
                         const double *axis)
{
    for (int k = 0; k < 3; k++) {
        double *m = (double *)&K->column[k];
        for (int i = 0; i < 3; i++) m[i] = i == k ? slope : 0;
        turn_rate(m, w, side);
        const double off = axis ? mukca_dot3(axis, m) : 0;
        for (int i = 0; i < 3 && axis; i++) m[i] -= off * axis[i];
    }
}

/* Transform a vector from base coordinates to the level frame. */
PART void to_level(lanes *v, const columns *level)
{
    double turned[3];
    to_joint(turned, level, XYZ(v));
    memcpy(v, turned, sizeof turned);
}

/* Set the level frame, with z parallel to gravity (the base frame if it is level), and transform
 * the posture to it. */
PART void set_level(tip_columns *c, mukca_equilibrium *e)
{
    const double *g = XYZ(e->gravity), size = mukca_norm3(g);
    columns_base(&c->level, NULL);
    c->g = g[2];
    if (g[0] == 0 && g[1] == 0) return;
    const double along[3] = {g[0] / size, g[1] / size, g[2] / size};
    double *x = (double *)c->level.column[0], *y = (double *)c->level.column[1];
    mukca_rotation_transverse(x, y, along);
    memcpy(c->level.column[2], along, sizeof along);
    c->g = size;
    to_level(e->first, &c->level);
    for (mukca_joint_posture *at = e->joint; at < e->joint + e->n_joints; at++) {
        lanes *vector[] = {at->axis, at->first, at->into_M, at->into_N};
        for (int k = 0; k < 4; k++) to_level(vector[k], &c->level);
        for (int k = 0; k < 3 && at->rotates; k++) to_level(at->frame.column[k], &c->level);
    }
}

/* Transform rotation vectors to the level frame, and their derivatives by the joint angles to
 * angular velocities; the matrix of set_compliance() replaces the frame of a joint that bends. */
PART void prepare(mukca_equilibrium *e, mukca_effect_slopes *slopes)
{
    for (int j = 0; j < e->n_joints; j++) {
        mukca_joint_posture *at = &e->joint[j];
        double *rate = slopes->rotation[j], *w = e->displacement.rotation[j];
        at->turns = rate[0] != 0 || rate[1] != 0 || rate[2] != 0;
        if (!at->turns && at->bend == 0) continue;
        to_base(w, &at->frame, w);
        if (at->turns) {
            to_base(rate, &at->frame, rate);
            turn_rate(rate, w, -1);
        }
        if (at->bend != 0) set_compliance(&at->frame, w, 1, at->bend, XYZ(at->axis));
    }
}

PART void set_motion(rows *m, const lanes *linear, const lanes *angular)
{
    memset(m, 0, sizeof *m);
    for (int r = 0; r < ROWS; r++) m->row[r] = linear[r], m->row[ALL / 2 + r] = angular[r];
}

/* Motion of the rigid arm's tip by rotation about an axis through p. */
PART void set_turn(rows *m, const mukca_equilibrium *e, const lanes *axis, const lanes *p)
{
    lanes lever[ROWS], shift[ROWS];
    for (int r = 0; r < ROWS; r++) lever[r] = e->tip.column[3][r] - p[r];
    columns_cross(shift, axis, lever);
    set_motion(m, shift, axis);
}

/* Columns of the rigid arm. */
PART void set_columns(rows *joint, const mukca_equilibrium *e)
{
    const lanes none[ROWS] = {0};
    for (int j = 0; j < e->n_joints; j++) {
        const mukca_joint_posture *at = &e->joint[j];
        if (at->slides)
            set_motion(&joint[j], at->axis, none);
        else
            set_turn(&joint[j], e, at->axis, at->frame.column[3]);
    }
}

/* out[3] := tip's motion, with response, per rotation about x, y and z of all bodies distal of p,
 * with first moment S about p. */
PART void rotate_distal(rows out[3], const tip_response *t, const tip_columns *c, const lanes *p,
                        const double S[3])
{
    const rows *M = t->by_M, *N = t->by_N;
    for (int i = 0; i < 3; i++) set_turn(&out[i], c->e, c->level.column[i], p);
    for (int r = 0; r < ALL; r++) {
        out[0].row[r] -= M[1].row[r] * S[2] + N[1].row[r] * c->g;
        out[1].row[r] += M[0].row[r] * S[2] + N[0].row[r] * c->g;
        out[2].row[r] -= M[0].row[r] * S[1] - M[1].row[r] * S[0];
    }
}

/* v := K v */
PART void apply(rows v[3], const columns *K)
{
    for (int r = 0; r < ALL; r++) {
        const lanes x = v[0].row[r], y = v[1].row[r], z = v[2].row[r];
        for (int i = 0; i < 3; i++)
            v[i].row[r] = COLUMN(K, 0, i) * x + COLUMN(K, 1, i) * y + COLUMN(K, 2, i) * z;
    }
}

/* (x, y) := m^-1 (x, y), m[4] row-major. */
PART void solve(rows *x, rows *y, const double m[4])
{
    const double size = 1 / (m[0] * m[3] - m[1] * m[2]);
    const double inverse[4] = {size * m[3], -size * m[1], -size * m[2], size * m[0]};
    for (int r = 0; r < ALL; r++) {
        const lanes right = x->row[r];
        x->row[r] = inverse[0] * right + inverse[1] * y->row[r];
        y->row[r] = inverse[2] * right + inverse[3] * y->row[r];
    }
}

/* by_M += v x g: share of a frame that moves the tip by v per moment. */
PART void add_share(tip_response *t, const rows v[3], double g)
{
    for (int r = 0; r < ALL; r++) {
        t->by_M[0].row[r] += v[1].row[r] * g;
        t->by_M[1].row[r] -= v[0].row[r] * g;
    }
}

/* Start with units of by_N and the response of the base, v per moment.  It adds v x g to by_M,
 * which contributes to v: a 2 x 2 system. */
PART void pass_base(tip_response *t, const tip_columns *c, mukca_equilibrium *e)
{
    static const lanes origin[ROWS];
    static const double unit[2][8] = {{[UNIT] = 1}, {[4 + UNIT] = 1}};
    const double *S = XYZ(e->first);
    double *w = e->displacement.base, own[4];
    columns K;
    rows v[3];
    memset(t, 0, sizeof *t);
    memcpy(t->by_N, unit, sizeof unit);
    if (e->bend == 0) return;
    to_joint(w, &c->level, w);
    set_compliance(&K, w, -1, e->bend, NULL);
    rotate_distal(v, t, c, origin, S);
    apply(v, &K);
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++)
            own[2 * i + k] = (i == k) - c->g * (COLUMN(&K, k, i) * S[2] - COLUMN(&K, 2, i) * S[k]);
    solve(&v[0], &v[1], own);
    add_share(t, v, c->g);
}

/* Move the joint's share from by_N to by_M; distribute its motion of the tip to its own column and
 * its neighbours'. */
PART void pass_joint(tip_response *t, tip_columns *c, int j)
{
    const mukca_joint_posture *at = &c->e->joint[j];
    const double *M = XYZ(at->into_M), *N = XYZ(at->into_N), *S = XYZ(at->first);
    const double *by = c->slopes->angle[j], *w = c->slopes->rotation[j];
    rows *own = &c->joint[j], rate = t->before, v[3];
    if (at->turns || at->bend != 0) rotate_distal(v, t, c, at->frame.column[3], S);
    for (int r = 0; r < ALL && at->turns; r++)
        rate.row[r] += v[0].row[r] * w[0] + v[1].row[r] * w[1] + v[2].row[r] * w[2];
    if (at->bend != 0) {
        apply(v, &at->frame);
        add_share(t, v, c->g);
        for (int r = 0; r < ALL; r++) {
            t->by_N[0].row[r] -= v[1].row[r] * S[2] - v[2].row[r] * S[1];
            t->by_N[1].row[r] += v[0].row[r] * S[2] - v[2].row[r] * S[0];
        }
    }
    for (int r = 0; r < ALL; r++) {
        const lanes turn = own->row[r] + (t->by_M[0].row[r] * M[0] + t->by_M[1].row[r] * M[1]) +
                           (t->by_N[0].row[r] * N[0] + t->by_N[1].row[r] * N[1]);
        for (int i = 0; i < 2 && at->deflects; i++) {
            t->by_M[i].row[r] += at->twist * N[i] * turn;
            t->by_N[i].row[r] -= at->twist * M[i] * turn;
        }
        own->row[r] = rate.row[r] + by[1] * turn;
        t->before.row[r] = by[2] * turn;
        if (j > 0) own[-1].row[r] += by[0] * turn;
    }
}

MUKCA_CLONES void mukca_equilibrium_differentiate(double *J, mukca_equilibrium *e,
                                                  mukca_effect_slopes *slopes)
{
    const int n = e->n_joints;
    tip_columns c;
    tip_response t;
    c.e = e, c.slopes = slopes;
    set_columns(c.joint, e);
    set_level(&c, e);
    prepare(e, slopes);
    pass_base(&t, &c, e);
    for (int j = 0; j < n; j++) pass_joint(&t, &c, j);
    rows *end = t.by_N;
    const double *x = XYZ(end[0].row), *y = XYZ(end[1].row);
    const double of_units[4] = {x[UNIT], x[4 + UNIT], y[UNIT], y[4 + UNIT]};
    solve(&end[0], &end[1], of_units);
    for (int j = 0; j < n; j++) {
        const double *own = XYZ(c.joint[j].row), first = own[UNIT], second = own[4 + UNIT];
        for (int r = 0; r < ALL; r++)
            c.joint[j].row[r] -= end[0].row[r] * first + end[1].row[r] * second;
        for (int i = 0; i < 6; i++) J[i * n + j] = own[i + i / 3];
    }
}

/* ---- response of an arm under load: deflections change the load, which changes the deflections
 * ---- */

/* Change of all deflections; rotations in base coordinates. */
typedef struct {
    double angle[MUKCA_MAX_JOINTS];
    LANES_ALIGNED lanes rotation[MUKCA_MAX_JOINTS][ROWS], base[ROWS];
} motion;

/* Set a rotation's change to v, in base coordinates, and add it to the deflection: change += v, in
 * the joint's frame.  Returns v.v. */
PART double set_change(double change[3], lanes *rotation, const columns *F, const lanes *v)
{
    double own[3];
    if (F) to_joint(own, F, XYZ(v));
    for (int a = 0; a < 3; a++) change[a] += F ? own[a] : XYZ(v)[a];
    for (int r = 0; r < ROWS; r++) rotation[r] = v[r];
    return columns_dot(v, v);
}

/* own[ROWS] := response of a joint's rotation to N and M. */
PART void bend_joint(lanes *own, const mukca_equilibrium *e, const mukca_joint_posture *at,
                     const lanes *N, const lanes *M)
{
    columns_cross(own, e->gravity, M);
    columns_add_cross(own, at->first, N);
    const double along = columns_dot(at->axis, own);
    for (int r = 0; r < ROWS; r++) own[r] = at->bend * (own[r] - along * at->axis[r]);
}

/* m := the deflections due to the change of load by m; change += these.  Returns the sum of their
 * squares.  Outwards from the base: M starts with all contributions and loses them, N accumulates
 * them. */
PART double respond(mukca_deflection *change, motion *m, const mukca_equilibrium *e)
{
    lanes N[ROWS] = {0}, M[ROWS] = {0}, own[ROWS] = {0};
    double squares = 0;
    if (e->bend != 0) columns_add_cross(M, m->base, e->first);
    for (int i = 0; i < e->n_deflecting; i++) {
        const int j = e->deflecting[i];
        const mukca_joint_posture *at = &e->joint[j];
        for (int r = 0; r < ROWS; r++) M[r] += at->into_M[r] * m->angle[j];
        if (at->bend != 0) columns_add_cross(M, m->rotation[j], at->first);
    }
    if (e->bend != 0) {
        columns_cross(own, e->gravity, M);
        for (int r = 0; r < ROWS; r++) own[r] *= e->bend;
        columns_subtract_cross(M, m->base, e->first);
        columns_cross(N, m->base, e->gravity);
        squares += set_change(change->base, m->base, NULL, own);
    }
    for (int i = 0; i < e->n_deflecting; i++) {
        const int j = e->deflecting[i];
        const mukca_joint_posture *at = &e->joint[j];
        const double angle = m->angle[j];
        if (at->bend != 0) {
            columns_add_cross(N, m->rotation[j], e->gravity);
            columns_subtract_cross(M, m->rotation[j], at->first);
            bend_joint(own, e, at, N, M);
            squares += set_change(change->rotation[j], m->rotation[j], &at->frame, own);
        }
        for (int r = 0; r < ROWS; r++) own[r] = at->into_N[r] * M[r] + at->into_M[r] * N[r];
        m->angle[j] = at->twist * (XYZ(own)[0] + XYZ(own)[1] + XYZ(own)[2]);
        change->angle[j] += m->angle[j];
        squares += m->angle[j] * m->angle[j];
        for (int r = 0; r < ROWS; r++) {
            M[r] -= at->into_M[r] * angle;
            N[r] += at->into_N[r] * angle;
        }
    }
    return squares;
}

MUKCA_CLONES void mukca_equilibrium_settle(mukca_deflection *change, const mukca_equilibrium *e,
                                           double within)
{
    enum { ROUNDS = 8 };
    motion m;
    for (int a = 0; a < ROWS; a++) m.base[a] = (lanes){0};
    for (int a = 0; a < 3; a++) ((double *)m.base)[a] = change->base[a];
    for (int i = 0; i < e->n_deflecting; i++) {
        const int j = e->deflecting[i];
        m.angle[j] = change->angle[j];
        if (e->joint[j].bend != 0)
            columns_vector(m.rotation[j], &e->joint[j].frame, change->rotation[j]);
    }
    for (int round = 0; round < ROUNDS; round++)
        if (!(respond(change, &m, e) > within * within)) return;
}
