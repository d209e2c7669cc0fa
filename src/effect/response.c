/* Response of an arm under load: deflections change the load, which changes the deflections. */
#include "effect/equilibrium.h"

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
