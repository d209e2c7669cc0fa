/* Jacobian of the corrected arm: the equilibrium under load moves with the joints' angles.
 *
 * Everything is in base coordinates, at the displaced posture.  A joint's frame turns about its
 * origin by the effects' rotation, then the joint turns by its angle.  S is the first moment of
 * what a joint carries about its origin, g gravity: the holding moment is g x S.  As the frame
 * before the joint turns by W, and what the joint carries moves in it so that S changes by Y, the
 * moment changes in this frame by (g x W) x S + g x Y.  Effects answer with angles and rotations: a
 * fixed point, as that of mukca_effects_displacement, for several columns of the Jacobian at a
 * time.
 */
#include "arm/corrected_jacobian.h"

#include <string.h>

#include "model/turn.h"
#include "mukca/gravity.h"

/* With several lanes part of the function that is compiled for each processor; with one apart: a
 * small controller has little stack and memory for code. */
#if MUKCA_LANES > 1
#define PART MUKCA_INLINE
#else
#define PART static __attribute__((noinline))
#endif

typedef struct {
    double axis[3], origin[3]; /* of the joint */
    double bent[3];            /* rotation vector of its effects */
    double kg, first[3];       /* carried; first moment about `origin`, kg m */
    bool slides;
} joint_posture;

typedef struct {
    mukca_effect_slopes *slopes; /* rotations in base coordinates, too */
    joint_posture joint[MUKCA_MAX_JOINTS];
    double gravity[3], base[3]; /* the base's rotation vector */
    double first[3];            /* of all that moves, about the base's origin */
    mukca_frame tip;
    int n_joints;
} posture;

/* Rates of the posture as MUKCA_LANES joints turn, each on its own. */
typedef struct {
    lanes angle[MUKCA_MAX_JOINTS];       /* rad/rad, m/m: with what the effects add */
    lanes rotation[MUKCA_MAX_JOINTS][3]; /* angular velocity by the effects' rotation */
    lanes base[3];
} rates;

/* c += sign a x b */
PART void add_cross(lanes c[3], double sign, const double a[3], const lanes b[3])
{
    c[0] += sign * (a[1] * b[2] - a[2] * b[1]);
    c[1] += sign * (a[2] * b[0] - a[0] * b[2]);
    c[2] += sign * (a[0] * b[1] - a[1] * b[0]);
}

#define DOT(a, b) ((a)[0] * (b)[0] + (a)[1] * (b)[1] + (a)[2] * (b)[2])

/* Angular velocity of exp([w]x) as w changes by `rate`, in the coordinates before (side 1) or after
 * (-1) that rotation: the left and right Jacobian of SO(3); the series is exact to 1e-9 up to |w| =
 * 0.2 rad. */
PART void angular_velocity(lanes omega[3], const double w[3], const lanes rate[3], double side)
{
    const double t2 = mukca_dot3(w, w);
    const double a = side * (0.5 - t2 / 24 + t2 * t2 / 720),
                 b = 1.0 / 6 - t2 / 120 + t2 * t2 / 5040;
    lanes once[3] = {0}, twice[3] = {0};
    add_cross(once, 1, w, rate);
    add_cross(twice, 1, w, once);
    for (int i = 0; i < 3; i++) omega[i] = rate[i] + a * once[i] + b * twice[i];
}

/* Frames and masses along the chain, outwards, then what each joint carries, inwards. */
PART void set_posture(posture *p, const mukca_corrected_point *point)
{
    const mukca_corrected *model = point->model;
    const mukca_displacement *d = point->displacement;
    const mukca_geometry *g = &model->geometry;
    double kg[MUKCA_MAX_ELEMENTS], first[MUKCA_MAX_ELEMENTS][3], sum[3] = {0, 0, 0}, total = 0;
    joint_angles at;
    columns F;
    mukca_chain_masses(kg, first, &model->chain, NULL, point->payload_kg);
    p->slopes = point->slopes;
    p->n_joints = g->n_joints;
    memcpy(p->gravity, model->chain.gravity, sizeof p->gravity);
    memcpy(p->base, d->base, sizeof p->base);
    columns_base(&F, d);
    mukca_joint_angles_set(&at, g, point->q, d);
    for (int k = 0; k < g->n_elements; k++) {
        const int j = g->joint[k];
        lanes turned[3][ROWS], moment[ROWS];
        columns_enter(&F, g, k);
        if (j >= 0) {
            joint_posture *joint = &p->joint[j];
            columns_displace(&F, j, d);
            columns_vector(turned[0], &F, g->axis[k]);
            columns_vector(turned[1], &F, d->rotation[j]);
            columns_vector(turned[2], &F, p->slopes->rotation[j]);
            memcpy(joint->axis, turned[0], sizeof joint->axis);
            memcpy(joint->bent, turned[1], sizeof joint->bent);
            memcpy(p->slopes->rotation[j], turned[2], sizeof joint->bent);
            memcpy(joint->origin, F.column[3], sizeof joint->origin);
            joint->slides = g->type[k] == MUKCA_PRISMATIC;
            columns_turn(&F, g, k, &at);
        }
        columns_vector(moment, &F, first[k]);
        for (int r = 0; r < ROWS; r++) moment[r] += kg[k] * F.column[3][r];
        memcpy(first[k], moment, sizeof first[k]);
    }
    columns_move(&F, d->tip);
    columns_frame(&p->tip, &F);
    for (int k = g->n_elements - 1; k >= 0; k--) {
        const int j = g->joint[k];
        total += kg[k];
        for (int i = 0; i < 3; i++) sum[i] += first[k][i];
        for (int i = 0; i < 3 && j >= 0; i++)
            p->joint[j].first[i] = sum[i] - total * p->joint[j].origin[i];
        if (j >= 0) p->joint[j].kg = total;
    }
    memcpy(p->first, sum, sizeof sum);
}

/* Slopes by load, at the torques of the posture. */
static void set_springs(posture *p, const mukca_corrected *model)
{
    double torque[MUKCA_MAX_JOINTS], moment[3];
    const mukca_joint_state loaded = {.torque = torque};
    for (int j = 0; j < p->n_joints; j++) {
        const joint_posture *joint = &p->joint[j];
        mukca_cross(moment, p->gravity, joint->first);
        torque[j] = joint->slides ? -joint->kg * mukca_dot3(joint->axis, p->gravity)
                                  : mukca_dot3(joint->axis, moment);
    }
    mukca_effects_slopes_by_load(p->slopes, model->effects, model->n_effects, &loaded);
}

/* Rates without load as joints `first`, `first` + 1, ... turn. */
PART void set_unloaded(rates *r, const posture *p, int first)
{
    memset(r, 0, sizeof *r);
    for (int l = 0; l < MUKCA_LANES && first + l < p->n_joints; l++) {
        const int j = first + l;
        for (int other = j > 0 ? j - 1 : 0; other <= j + 1 && other < p->n_joints; other++)
            ((double *)&r->angle[other])[l] = p->slopes->angle[other][1 + j - other];
        ((double *)&r->angle[j])[l] += 1;
        for (int i = 0; i < 3; i++) ((double *)&r->rotation[j][i])[l] = p->slopes->rotation[j][i];
    }
    for (int j = first; j < first + MUKCA_LANES && j < p->n_joints; j++)
        angular_velocity(r->rotation[j], p->joint[j].bent, r->rotation[j], -1);
}

/* One round towards the equilibrium: each joint answers to its change of moment.  Returns the
 * square of what that changed. */
MUKCA_INLINE double settle_once(rates *r, const rates *unloaded, const posture *p)
{
    lanes before[MUKCA_MAX_JOINTS][3], carried[3] = {0}, turn[3], changed = {0};
    for (int i = 0; i < 3; i++) turn[i] = r->base[i];
    for (int j = 0; j < p->n_joints; j++)
        for (int i = 0; i < 3; i++) {
            before[j][i] = turn[i] + r->rotation[j][i];
            turn[i] = before[j][i];
            if (!p->joint[j].slides) turn[i] += p->joint[j].axis[i] * r->angle[j];
        }
    for (int j = p->n_joints - 1; j >= 0; j--) {
        const joint_posture *at = &p->joint[j];
        const double spring = p->slopes->spring[j], bend = p->slopes->bend[j];
        lanes own[3], tilt[3] = {0}, moment[3] = {0}, answer[3];
        for (int i = 0; i < 3; i++) own[i] = r->angle[j] * at->axis[i];
        for (int i = 0; i < 3 && at->slides; i++) carried[i] += at->kg * own[i];
        if (!at->slides) add_cross(carried, -1, at->first, own);
        if (spring != 0 || bend != 0) {
            add_cross(tilt, 1, p->gravity, before[j]);
            add_cross(moment, -1, at->first, tilt);
            add_cross(moment, 1, p->gravity, carried);
            const lanes along = DOT(at->axis, moment);
            lanes angle = unloaded->angle[j];
            if (at->slides)
                angle -= spring * at->kg * DOT(at->axis, tilt);
            else
                angle += spring * along;
            changed += (angle - r->angle[j]) * (angle - r->angle[j]);
            r->angle[j] = angle;
            for (int i = 0; i < 3; i++) moment[i] = bend * (moment[i] - along * at->axis[i]);
            angular_velocity(answer, at->bent, moment, -1);
            for (int i = 0; i < 3; i++) {
                answer[i] += unloaded->rotation[j][i];
                changed += (answer[i] - r->rotation[j][i]) * (answer[i] - r->rotation[j][i]);
                r->rotation[j][i] = answer[i];
            }
        }
        add_cross(carried, -1, at->first, r->rotation[j]);
    }
    if (p->slopes->base != 0) {
        lanes moment[3] = {0}, answer[3];
        add_cross(carried, -1, p->first, r->base);
        add_cross(moment, 1, p->gravity, carried);
        for (int i = 0; i < 3; i++) moment[i] *= p->slopes->base;
        angular_velocity(answer, p->base, moment, 1);
        for (int i = 0; i < 3; i++) {
            changed += (answer[i] - r->base[i]) * (answer[i] - r->base[i]);
            r->base[i] = answer[i];
        }
    }
    double of_lane[MUKCA_LANES], sum = 0;
    memcpy(of_lane, &changed, sizeof of_lane);
    for (int l = 0; l < MUKCA_LANES; l++) sum += of_lane[l];
    return sum;
}

/* The fixed point, closer than the rounding of the Jacobian: a round leaves of what is missing the
 * deflection per radian that the arm turns, 0.05 at most. */
PART void settle(rates *r, const posture *p)
{
    enum { ROUNDS = 8 };
    const rates unloaded = *r;
    for (int round = 0; round < ROUNDS; round++) {
        if (!(settle_once(r, &unloaded, p) > 1e-24)) return;
    }
}

/* Columns `first`, `first` + 1, ... of the Jacobian. */
PART void fill_columns(double *J, const rates *r, const posture *p, int first)
{
    const int n = p->n_joints;
    lanes v[3] = {0}, w[3];
    for (int i = 0; i < 3; i++) w[i] = r->base[i];
    for (int j = 0; j < n; j++) {
        const joint_posture *at = &p->joint[j];
        lanes turn[3];
        for (int i = 0; i < 3; i++) {
            const lanes own = r->angle[j] * at->axis[i];
            turn[i] = r->rotation[j][i];
            *(at->slides ? &v[i] : &turn[i]) += own;
            w[i] += turn[i];
        }
        add_cross(v, 1, at->origin, turn);
    }
    add_cross(v, -1, p->tip.p, w);
    for (int i = 0; i < 3; i++)
        for (int l = 0; l < MUKCA_LANES && first + l < n; l++) {
            J[i * n + first + l] = ((const double *)&v[i])[l];
            J[(3 + i) * n + first + l] = ((const double *)&w[i])[l];
        }
}

MUKCA_CLONES void mukca_corrected_differentiate(double *J, mukca_frame *T_base_tip,
                                                const mukca_corrected_point *at)
{
    posture p;
    rates r;
    set_posture(&p, at);
    if (at->loaded) set_springs(&p, at->model);
    if (T_base_tip) *T_base_tip = p.tip;
    for (int first = 0; first < p.n_joints; first += MUKCA_LANES) {
        set_unloaded(&r, &p, first);
        if (at->loaded) settle(&r, &p);
        fill_columns(J, &r, &p, first);
    }
}
