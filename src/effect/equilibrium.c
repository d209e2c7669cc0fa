/* The arm at rest under its load, with its effects. */
#include "effect/equilibrium.h"

#include <math.h>
#include <string.h>

#include "effect/catalogue.h"
#include "mukca/gravity.h"

/* A vector of a joint's frame in base coordinates, and back. */
PART void to_base(double out[3], const columns *F, const double v[3])
{
    lanes turned[ROWS];
    columns_vector(turned, F, v);
    for (int i = 0; i < 3; i++) out[i] = ((const double *)turned)[i];
}

static void to_joint(double out[3], const columns *F, const double v[3])
{
    const double x = v[0], y = v[1], z = v[2];
    for (int c = 0; c < 3; c++)
        out[c] = COLUMN(F, c, 0) * x + COLUMN(F, c, 1) * y + COLUMN(F, c, 2) * z;
}

/* Frames and moments of masses along the chain, outwards, then what each joint carries, inwards. */
PART void set_posture(mukca_equilibrium *e, const mukca_effect_task *task)
{
    const mukca_geometry *g = task->geometry;
    const mukca_displacement *d = &e->displacement;
    double kg[MUKCA_MAX_ELEMENTS], first[MUKCA_MAX_ELEMENTS][3], total = 0;
    joint_angles at;
    columns F;
    mukca_chain_masses(kg, first, task->chain, NULL, task->state.payload_kg);
    columns_base(&F, d);
    at.q = at.moved;
    at.moved[0] = 0; /* of an arm without joints */
    for (int j = 0; j < g->n_joints; j++) at.moved[j] = task->state.q[j] + d->q[j];
    if (!mukca_sincos_near(at.s, at.c, at.moved, g->n_joints)) at.s[0] = at.c[0] = (double)NAN;
    for (int k = 0; k < g->n_elements; k++) {
        const int j = g->joint[k];
        columns_enter(&F, g, k);
        if (j >= 0) {
            columns_displace(&F, j, d);
            e->joint[j].frame = F;
            columns_turn(&F, g, k, &at);
        }
        lanes moment[ROWS];
        columns_vector(moment, &F, first[k]);
        for (int r = 0; r < ROWS; r++) moment[r] += kg[k] * F.column[3][r];
        memcpy(first[k], moment, sizeof first[k]);
    }
    columns_move(&F, d->tip);
    columns_frame(&e->tip, &F);
    memset(e->first, 0, sizeof e->first);
    for (int k = g->n_elements - 1; k >= 0; k--) {
        const int j = g->joint[k];
        total += kg[k];
        for (int i = 0; i < 3; i++) e->first[i] += first[k][i];
        if (j < 0) continue;
        mukca_joint_posture *joint = &e->joint[j];
        to_base(joint->axis, &joint->frame, g->axis[k]);
        for (int i = 0; i < 3; i++)
            joint->first[i] = e->first[i] - total * COLUMN(&joint->frame, 3, i);
        joint->kg = total;
    }
}

static void set_lever(mukca_joint_posture *joint)
{
    mukca_cross(joint->moved, joint->axis, joint->first);
    for (int i = 0; i < 3 && joint->slides; i++) joint->moved[i] = joint->kg * joint->axis[i];
}

void mukca_equilibrium_rates(mukca_equilibrium *e, mukca_effect_slopes *slopes)
{
    e->found = true;
    for (int j = 0; j < e->n_joints; j++) {
        mukca_joint_posture *at = &e->joint[j];
        double *rate = slopes->rotation[j], *bent = e->displacement.rotation[j];
        set_lever(at);
        at->tilts |= rate[0] != 0 || rate[1] != 0 || rate[2] != 0;
        to_base(bent, &at->frame, bent);
        to_base(rate, &at->frame, rate);
    }
}

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
    const lanes along = b * DOT(w, rate);
    lanes across[3] = {0};
    add_cross(across, a, w, rate);
    for (int i = 0; i < 3; i++) omega[i] = (1 - b * t2) * rate[i] + across[i] + along * w[i];
}

/* Answer of a joint's rotation as its frame turns by `turned` and what it carries moves by
 * `carried`. */
PART void bend_joint(lanes rotation[3], const mukca_equilibrium *e, int j, const lanes turned[3],
                     const lanes carried[3])
{
    const mukca_joint_posture *at = &e->joint[j];
    const double down = mukca_dot3(e->gravity, at->first);
    const lanes lever = DOT(at->first, turned); /* (g x W) x S = (S g) W - (S W) g */
    lanes moment[3];
    for (int i = 0; i < 3; i++) moment[i] = down * turned[i] - lever * e->gravity[i];
    add_cross(moment, 1, e->gravity, carried);
    const lanes along = DOT(at->axis, moment);
    for (int i = 0; i < 3; i++) rotation[i] = at->bend * (moment[i] - along * at->axis[i]);
    if (e->found) angular_velocity(rotation, e->displacement.rotation[j], rotation, -1);
}

/* The same of its angle: the torque of one that turns changes by a (g x Y) + (g x M) W = g (Y x a +
 * M x W) with M what moves S, and M g is minus the force along the axis of one that slides. */
PART void twist_joint(lanes *angle, const mukca_equilibrium *e, int j, const lanes turned[3],
                      const lanes carried[3])
{
    const mukca_joint_posture *at = &e->joint[j];
    lanes v[3] = {0};
    add_cross(v, at->spring, at->moved, turned);
    if (!at->slides) add_cross(v, -at->spring, at->axis, carried);
    *angle = DOT(e->gravity, v);
}

/* r := the answers of the joints and the base to the change of the load that r brings about.
 * `some`: r is zero but for what yields to the load. */
PART void answer(mukca_posture_rates *r, const mukca_equilibrium *e, bool some)
{
    lanes turned[MUKCA_MAX_JOINTS][3], carried[3] = {0}, turn[3];
    for (int i = 0; i < 3; i++) turn[i] = r->base[i];
    for (int j = 0; j < e->n_joints; j++) {
        const mukca_joint_posture *at = &e->joint[j];
        if (some && !at->yields) continue;
        for (int i = 0; i < 3 && at->tilts; i++) turn[i] += r->rotation[j][i];
        for (int i = 0; i < 3; i++) turned[j][i] = turn[i];
        for (int i = 0; i < 3 && !at->slides; i++) turn[i] += at->axis[i] * r->angle[j];
    }
    for (int j = e->n_joints - 1; j >= 0; j--) {
        const mukca_joint_posture *at = &e->joint[j];
        lanes own[3];
        if (some && !at->yields) continue;
        for (int i = 0; i < 3; i++) carried[i] += at->moved[i] * r->angle[j];
        twist_joint(&r->angle[j], e, j, turned[j], carried);
        if (!at->tilts) continue;
        for (int i = 0; i < 3; i++) own[i] = r->rotation[j][i], r->rotation[j][i] = (lanes){0};
        if (at->bend != 0) bend_joint(r->rotation[j], e, j, turned[j], carried);
        add_cross(carried, -1, at->first, own);
    }
    if (e->spring == 0) return;
    const double down = mukca_dot3(e->gravity, e->first);
    const lanes along = DOT(e->gravity, r->base); /* g x (W x S) = (g S) W - (g W) S */
    lanes moment[3];
    for (int i = 0; i < 3; i++) moment[i] = down * r->base[i] - along * e->first[i];
    add_cross(moment, 1, e->gravity, carried);
    for (int i = 0; i < 3; i++) r->base[i] = e->spring * moment[i];
    if (e->found) angular_velocity(r->base, e->displacement.base, r->base, 1);
}

/* rates += r, where something yields.  Returns the sum of squares. */
PART double add_answer(mukca_posture_rates *rates, const mukca_posture_rates *r,
                       const mukca_equilibrium *e)
{
    lanes squares = {0};
    for (int i = 0; i < 3; i++) {
        rates->base[i] += r->base[i];
        squares += r->base[i] * r->base[i];
    }
    for (int j = 0; j < e->n_joints; j++) {
        const mukca_joint_posture *at = &e->joint[j];
        if (!at->yields) continue;
        rates->angle[j] += r->angle[j];
        squares += r->angle[j] * r->angle[j];
        for (int i = 0; i < 3 && at->tilts; i++) {
            rates->rotation[j][i] += r->rotation[j][i];
            squares += r->rotation[j][i] * r->rotation[j][i];
        }
    }
    double of_lane[MUKCA_LANES], sum = 0;
    memcpy(of_lane, &squares, sizeof of_lane);
    for (int l = 0; l < MUKCA_LANES; l++) sum += of_lane[l];
    return sum;
}

/* `some`: as of answer, and the rates become the answers alone. */
PART void settle(mukca_posture_rates *rates, const mukca_equilibrium *e, bool some, double within)
{
    enum { ROUNDS = 8 };
    mukca_posture_rates r;
    for (int i = 0; i < 3; i++) r.base[i] = rates->base[i];
    for (int j = 0; j < e->n_joints; j++) {
        const mukca_joint_posture *at = &e->joint[j];
        r.angle[j] = rates->angle[j];
        if (!at->tilts) continue;
        if (e->found)
            angular_velocity(rates->rotation[j], e->displacement.rotation[j], rates->rotation[j],
                             -1);
        for (int i = 0; i < 3; i++) r.rotation[j][i] = rates->rotation[j][i];
    }
    if (some) memset(rates, 0, sizeof *rates);
    for (int round = 0; round < ROUNDS && e->loaded; round++) {
        answer(&r, e, some || round > 0);
        if (!(add_answer(rates, &r, e) > within * within)) return;
    }
}

MUKCA_CLONES void mukca_equilibrium_settle(mukca_posture_rates *rates, const mukca_equilibrium *e,
                                           double within)
{
    settle(rates, e, false, within);
}

static bool is_loaded(const mukca_effect *effect)
{
    return (mukca_effect_table[effect->kind]->needs & MUKCA_NEEDS_MASSES) != 0;
}

/* Load of the joints that yield and of the base. */
static void find_load(mukca_gravity_load *load, const mukca_equilibrium *e)
{
    for (int j = 0; j < e->n_joints; j++) {
        const mukca_joint_posture *at = &e->joint[j];
        double moment[3];
        if (!at->yields) continue;
        mukca_cross(moment, e->gravity, at->first);
        load->torque[j] =
            at->slides ? -at->kg * mukca_dot3(at->axis, e->gravity) : mukca_dot3(at->axis, moment);
        if (at->tilts) to_joint(load->moment[j], &at->frame, moment);
    }
    mukca_cross(load->base, e->gravity, e->first);
}

/* What the effects add under the load at the posture, and their slopes by it. */
static void apply_loaded(mukca_displacement *d, mukca_equilibrium *e, const mukca_effect_task *task)
{
    mukca_gravity_load load;
    mukca_joint_state state = task->state;
    if (e->loaded) {
        find_load(&load, e);
        state.torque = load.torque;
        state.moment = (const double(*)[3])load.moment;
        state.base_moment = load.base;
    }
    e->spring = 0;
    for (int j = 0; j < e->n_joints; j++) e->joint[j].spring = e->joint[j].bend = 0;
    for (int i = 0; i < e->n_yielding; i++) {
        const mukca_effect *f = task->effects + e->yielding[i];
        const mukca_effect_ops *ops = mukca_effect_catalogue[f->kind];
        double basis[MUKCA_MAX_TERMS][3] = {{0}}, *slope = &e->spring;
        ops->basis(basis,
                   &(mukca_basis_input){
                       .effect = f, .axis = mukca_effect_axis(f, task->chain), .state = &state});
        mukca_effect_add(d, f, (const double(*)[3])basis);
        if (!e->loaded) continue;
        if (ops->info.site == MUKCA_SITE_ANGLE) slope = &e->joint[f->joint].spring;
        if (ops->info.site == MUKCA_SITE_ROTATION) slope = &e->joint[f->joint].bend;
        *slope += f->coefficient[0] * ops->by_load(f, basis[0]);
    }
}

/* to := from, of n joints */
static void copy(mukca_displacement *to, const mukca_displacement *from, int n)
{
    memcpy(to->q, from->q, (size_t)n * sizeof *to->q);
    memcpy(to->rotation, from->rotation, (size_t)n * sizeof *to->rotation);
    memcpy(to->base, from->base, sizeof to->base);
    memcpy(to->tip, from->tip, sizeof to->tip);
    to->any_rotation = from->any_rotation;
}

/* rad or m: seven joints and their rotations together keep the tip within 1e-12. */
static const double rest = 1e-13;

/* The same in all lanes, and what the first one has. */
#define ALL(x) ((x) + (lanes){0})
#define FIRST(rate) (*(const double *)(const void *)&(rate))

/* A step of Newton's method: the displacement becomes what the effects add under the load of the
 * posture, with the answers to the difference.  Returns the largest part of it, rad or m. */
PART double step(mukca_equilibrium *e, const mukca_effect_task *task,
                 const mukca_displacement *unloaded)
{
    mukca_displacement *d = &e->displacement;
    mukca_posture_rates r; /* what was, then the difference, then the answers */
    const int n = e->n_joints;
    double size = 0;
    for (int i = 0; i < 3; i++) r.base[i] = ALL(d->base[i]);
    for (int j = 0; j < n; j++) {
        r.angle[j] = ALL(d->q[j]);
        for (int i = 0; i < 3; i++) r.rotation[j][i] = ALL(d->rotation[j][i]);
    }
    copy(d, unloaded, n);
    apply_loaded(d, e, task);
    for (int j = 0; j < n; j++) {
        mukca_joint_posture *at = &e->joint[j];
        double change[3];
        if (!at->yields) continue;
        set_lever(at);
        r.angle[j] = ALL(d->q[j]) - r.angle[j];
        size = fmax(size, fabs(FIRST(r.angle[j])));
        if (!at->tilts) continue;
        for (int i = 0; i < 3; i++) {
            change[i] = d->rotation[j][i] - FIRST(r.rotation[j][i]);
            size = fmax(size, fabs(change[i]));
        }
        to_base(change, &at->frame, change);
        for (int i = 0; i < 3; i++) r.rotation[j][i] = ALL(change[i]);
    }
    for (int i = 0; i < 3; i++) {
        r.base[i] = ALL(d->base[i]) - r.base[i];
        size = fmax(size, fabs(FIRST(r.base[i])));
    }
    if (!(size > rest)) return size;
    settle(&r, e, true, 1e-2 * size);
    for (int j = 0; j < n; j++) {
        double turned[3];
        if (!e->joint[j].yields) continue;
        d->q[j] += FIRST(r.angle[j]);
        if (!e->joint[j].tilts) continue;
        for (int i = 0; i < 3; i++) turned[i] = FIRST(r.rotation[j][i]);
        to_joint(turned, &e->joint[j].frame, turned);
        for (int i = 0; i < 3; i++) d->rotation[j][i] += turned[i];
    }
    for (int i = 0; i < 3; i++) d->base[i] += FIRST(r.base[i]);
    return size;
}

static void start(mukca_equilibrium *e, const mukca_effect_task *task)
{
    const mukca_chain *chain = task->chain;
    memcpy(e->gravity, chain->gravity, sizeof e->gravity);
    e->found = false; /* rates are those of rotation vectors: right enough for Newton's method */
    e->n_joints = chain->n_joints;
    e->n_yielding = 0;
    for (int j = 0; j < chain->n_joints; j++) {
        mukca_joint_posture *at = &e->joint[j];
        at->slides = task->geometry->type[chain->joint_element[j]] == MUKCA_PRISMATIC;
        at->yields = at->tilts = false;
    }
    for (int i = 0; i < task->n_effects; i++) {
        const mukca_effect *f = &task->effects[i];
        if (!is_loaded(f)) continue;
        e->yielding[e->n_yielding++] = (unsigned char)i;
        if (f->joint < 0) continue;
        e->joint[f->joint].yields = true;
        e->joint[f->joint].tilts |= mukca_effect_table[f->kind]->site == MUKCA_SITE_ROTATION;
    }
    e->loaded = e->n_yielding > 0 && !task->state.torque;
}

MUKCA_CLONES void mukca_equilibrium_find(mukca_equilibrium *e, mukca_effect_slopes *slopes,
                                         const mukca_effect_task *task)
{
    enum { ROUNDS = 8 }; /* usually 2: Newton's method, from 1 mrad off */
    mukca_displacement unloaded;
    start(e, task);
    mukca_effects_unloaded(&unloaded, slopes, task);
    copy(&e->displacement, &unloaded, e->n_joints);
    if (!e->loaded) apply_loaded(&e->displacement, e, task); /* under torques that are given */
    for (int round = 0;; round++) {
        set_posture(e, task);
        if (!e->loaded || round == ROUNDS || !(step(e, task, &unloaded) > rest)) return;
    }
}

void mukca_effects_displacement(mukca_displacement *displacement, const mukca_effect *effects,
                                int n, const mukca_chain *chain, const mukca_geometry *geometry,
                                const double *q, const mukca_joint_state *state)
{
    mukca_equilibrium at;
    mukca_effect_task task = {
        .effects = effects, .n_effects = n, .chain = chain, .geometry = geometry};
    if (state) task.state = *state;
    if (!state) task.state.placement = -1;
    task.state.q = q;
    mukca_equilibrium_find(&at, NULL, &task);
    memset(displacement, 0, sizeof *displacement);
    copy(displacement, &at.displacement, chain->n_joints);
}
