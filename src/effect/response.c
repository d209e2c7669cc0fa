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

/* Angular velocity of exp([w]x) as w changes by `rate`, in the coordinates before (side 1) or after
 * (-1) that rotation: the left and right Jacobian of SO(3); the series is exact to 1e-9 up to |w| =
 * 0.2 rad. */
PART void angular_velocity(lanes omega[3], const double w[3], const lanes rate[3], double side)
{
    const double t2 = mukca_dot3(w, w);
    const double a = side * (0.5 - t2 * (1.0 / 24 - t2 * (1.0 / 720)));
    const double b = 1.0 / 6 - t2 * (1.0 / 120 - t2 * (1.0 / 5040));
    const lanes along = b * DOT(w, rate);
    const double aw[3] = {a * w[0], a * w[1], a * w[2]};
    lanes sum[3];
    for (int i = 0; i < 3; i++) sum[i] = (1 - b * t2) * rate[i] + along * w[i];
    add_cross(sum, aw, rate);
    for (int i = 0; i < 3; i++) omega[i] = sum[i];
}

MUKCA_CLONES void mukca_equilibrium_rates(mukca_equilibrium *e, mukca_effect_slopes *slopes)
{
    e->found = true;
    for (int j = 0; j < e->n_joints; j++) {
        mukca_joint_posture *at = &e->joint[j];
        double *rate = slopes->rotation[j], *bent = e->displacement.rotation[j];
        at->tilts |= rate[0] != 0 || rate[1] != 0 || rate[2] != 0;
        if (!at->tilts) continue;
        to_base(bent, &at->frame, bent);
        to_base(rate, &at->frame, rate);
        lanes omega[3] = {ALL(rate[0]), ALL(rate[1]), ALL(rate[2])};
        angular_velocity(omega, bent, omega, -1);
        for (int a = 0; a < 3; a++) rate[a] = FIRST(omega[a]);
    }
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
    if (e->found) angular_velocity(moment, e->displacement.rotation[j], moment, -1);
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
    if (e->found) angular_velocity(moment, e->displacement.base, moment, 1);
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
