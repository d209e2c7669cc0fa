/* Response of an arm under load to motions: rates of the posture, with the answers of what yields.
 */
#include <string.h>

#include "effect/equilibrium.h"

#define DOT(a, b) ((a)[0] * (b)[0] + (a)[1] * (b)[1] + (a)[2] * (b)[2])

/* c += a x b; c -= a x b */
PART void add_cross(lanes c[3], const double a[3], const lanes b[3])
{
    c[0] += a[1] * b[2] - a[2] * b[1];
    c[1] += a[2] * b[0] - a[0] * b[2];
    c[2] += a[0] * b[1] - a[1] * b[0];
}

PART void take_cross(lanes c[3], const double a[3], const lanes b[3])
{
    c[0] -= a[1] * b[2] - a[2] * b[1];
    c[1] -= a[2] * b[0] - a[0] * b[2];
    c[2] -= a[0] * b[1] - a[1] * b[0];
}

/* moment[3] := answer of a joint's rotation to N and M. */
PART void bend_joint(lanes moment[3], const mukca_equilibrium *e, int j, const lanes N[3],
                     const lanes M[3])
{
    const mukca_joint_posture *at = &e->joint[j];
    for (int i = 0; i < 3; i++) moment[i] = ALL(0);
    add_cross(moment, XYZ(e->gravity), M);
    add_cross(moment, XYZ(at->first), N);
    const lanes along = DOT(XYZ(at->axis), moment);
    for (int i = 0; i < 3; i++) moment[i] = at->bend * (moment[i] - along * XYZ(at->axis)[i]);
}

/* The same of the base; N gets its part. */
PART void bend_base(lanes moment[3], const mukca_equilibrium *e, const lanes base[3], lanes N[3],
                    const lanes M[3])
{
    lanes moved[3] = {M[0], M[1], M[2]};
    take_cross(moved, XYZ(e->first), base);
    take_cross(N, XYZ(e->gravity), base);
    for (int i = 0; i < 3; i++) moment[i] = ALL(0);
    add_cross(moment, XYZ(e->gravity), moved);
    for (int i = 0; i < 3; i++) moment[i] *= e->bend;
}

/* r := answer, rates += answer, squares += its square. */
PART void put(lanes *r, lanes *rates, lanes *squares, lanes answer)
{
    *r = answer;
    *rates += answer;
    *squares += answer * answer;
}

/* r := the answers of the joints and the base to the change of the load that r brings about; rates
 * += these answers, squares += their squares.  `some`: r is zero but for what yields to the load.
 * Outwards: M starts with all joints' parts and loses them, N gathers them. */
PART void answer(mukca_posture_rates *rates, mukca_posture_rates *r, lanes *squares,
                 const mukca_equilibrium *e, bool some)
{
    const int n = some ? e->n_yielding : e->n_joints;
    lanes N[3] = {ALL(0), ALL(0), ALL(0)}, M[3] = {ALL(0), ALL(0), ALL(0)}, own[3];
    for (int i = 0; i < n; i++) {
        const int j = some ? e->yielding[i] : i;
        const mukca_joint_posture *at = &e->joint[j];
        const lanes angle = r->angle[j];
        for (int a = 0; a < 3; a++) M[a] += XYZ(at->into_M)[a] * angle;
        if (some ? at->bend != 0 : at->tilts) take_cross(M, XYZ(at->first), r->rotation[j]);
    }
    if (e->bend != 0) {
        bend_base(own, e, r->base, N, M);
        for (int a = 0; a < 3; a++) put(&r->base[a], &rates->base[a], squares, own[a]);
    }
    for (int i = 0; i < n; i++) {
        const int j = some ? e->yielding[i] : i;
        const mukca_joint_posture *at = &e->joint[j];
        const lanes angle = r->angle[j];
        if (some ? at->bend != 0 : at->tilts) {
            take_cross(N, XYZ(e->gravity), r->rotation[j]);
            add_cross(M, XYZ(at->first), r->rotation[j]);
        }
        if (at->bend != 0) {
            bend_joint(own, e, j, N, M);
            for (int a = 0; a < 3; a++)
                put(&r->rotation[j][a], &rates->rotation[j][a], squares, own[a]);
        }
        if (some || at->yields)
            put(&r->angle[j], &rates->angle[j], squares,
                at->twist * (DOT(XYZ(at->into_N), M) + DOT(XYZ(at->into_M), N)));
        for (int a = 0; a < 3; a++) {
            M[a] -= XYZ(at->into_M)[a] * angle;
            N[a] += XYZ(at->into_N)[a] * angle;
        }
    }
}

MUKCA_CLONES void mukca_equilibrium_settle(mukca_posture_rates *rates, const mukca_equilibrium *e,
                                           bool some, double within)
{
    enum { ROUNDS = 8 };
    const int n = some ? e->n_yielding : e->n_joints;
    mukca_posture_rates r;
    for (int a = 0; a < 3; a++) r.base[a] = rates->base[a];
    for (int i = 0; i < n; i++) {
        const int j = some ? e->yielding[i] : i;
        r.angle[j] = rates->angle[j];
        for (int a = 0; a < 3 && e->joint[j].tilts; a++) r.rotation[j][a] = rates->rotation[j][a];
    }
    for (int round = 0; round < ROUNDS && e->loaded; round++) {
        lanes squares = ALL(0);
        double of_lane[MUKCA_LANES], sum = 0;
        answer(rates, &r, &squares, e, some || round > 0);
        memcpy(of_lane, &squares, sizeof of_lane);
        for (int l = 0; l < MUKCA_LANES; l++) sum += of_lane[l];
        if (!(sum > within * within)) return;
    }
}
