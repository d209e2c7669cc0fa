/* The arm at rest under its load, with its effects. */
#include "effect/equilibrium.h"

#include <math.h>
#include <string.h>

#include "effect/catalogue.h"
#include "mukca/gravity.h"

/* The same in all lanes. */
#define ALL(x) ((x) + (lanes){0})

#define DOT(a, b) ((a)[0] * (b)[0] + (a)[1] * (b)[1] + (a)[2] * (b)[2])

/* A vector of a joint's frame in base coordinates, and back. */
PART void to_base(double out[3], const columns *F, const double v[3])
{
    lanes turned[ROWS];
    columns_vector(turned, F, v);
    for (int i = 0; i < 3; i++) out[i] = XYZ(turned)[i];
}

static void to_joint(double out[3], const columns *F, const double v[3])
{
    const double x = v[0], y = v[1], z = v[2];
    for (int c = 0; c < 3; c++)
        out[c] = COLUMN(F, c, 0) * x + COLUMN(F, c, 1) * y + COLUMN(F, c, 2) * z;
}

/* The parts of a joint that carries `kg`. */
static void set_parts(mukca_joint_posture *joint, double kg, const double gravity[3])
{
    const double *axis = XYZ(joint->axis);
    mukca_cross(joint->into_M, axis, XYZ(joint->first));
    mukca_cross(joint->into_N, axis, gravity);
    for (int i = 0; i < 3 && joint->slides; i++)
        joint->into_M[i] = kg * axis[i], joint->into_N[i] = 0;
}

/* Frames and first moments of what moves with each joint, outwards, then of what each joint
 * carries, inwards. */
PART void set_posture(mukca_equilibrium *e, const mukca_effect_task *task)
{
    const mukca_geometry *g = task->geometry;
    const mukca_displacement *d = &e->displacement;
    double kg[MUKCA_MAX_ELEMENTS], first[MUKCA_MAX_ELEMENTS][3], total = 0;
    lanes sum[ROWS] = {0}, moment[ROWS], *body = e->first; /* about the base's origin */
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
            for (int c = 0; c < 4; c++)
                for (int r = 0; r < ROWS; r++) e->joint[j].frame.column[c][r] = F.column[c][r];
            columns_vector(e->joint[j].axis, &F, g->axis[k]);
            columns_turn(&F, g, k, &at);
            for (int r = 0; r < ROWS; r++) body[r] = sum[r], sum[r] = ALL(0);
            body = e->joint[j].first;
        }
        columns_vector(moment, &F, first[k]);
        for (int r = 0; r < ROWS; r++) sum[r] += moment[r] + kg[k] * F.column[3][r];
    }
    columns_move(&F, d->tip);
    columns_frame(&e->tip, &F);
    for (int r = 0; r < ROWS; r++) body[r] = sum[r], sum[r] = ALL(0);
    for (int k = g->n_elements - 1; k >= 0; k--) {
        const int j = g->joint[k];
        total += kg[k];
        if (j < 0) continue;
        mukca_joint_posture *joint = &e->joint[j];
        for (int r = 0; r < ROWS; r++) {
            sum[r] += joint->first[r];
            joint->first[r] = sum[r] - total * joint->frame.column[3][r];
        }
        set_parts(joint, total, e->gravity);
    }
    for (int r = 0; r < ROWS; r++) e->first[r] += sum[r];
}

void mukca_equilibrium_rates(mukca_equilibrium *e, mukca_effect_slopes *slopes)
{
    e->found = true;
    for (int j = 0; j < e->n_joints; j++) {
        mukca_joint_posture *at = &e->joint[j];
        double *rate = slopes->rotation[j], *bent = e->displacement.rotation[j];
        at->tilts |= rate[0] != 0 || rate[1] != 0 || rate[2] != 0;
        if (!at->tilts) continue;
        to_base(bent, &at->frame, bent);
        to_base(rate, &at->frame, rate);
    }
}

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

/* moment[3] := answer of a joint's rotation to N and M. */
PART void bend_joint(lanes moment[3], const mukca_equilibrium *e, int j, const lanes N[3],
                     const lanes M[3])
{
    const mukca_joint_posture *at = &e->joint[j];
    for (int i = 0; i < 3; i++) moment[i] = ALL(0);
    add_cross(moment, e->gravity, M);
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
    take_cross(N, e->gravity, base);
    for (int i = 0; i < 3; i++) moment[i] = ALL(0);
    add_cross(moment, e->gravity, moved);
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
        for (int a = 0; a < 3; a++) M[a] += at->into_M[a] * angle;
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
            take_cross(N, e->gravity, r->rotation[j]);
            add_cross(M, XYZ(at->first), r->rotation[j]);
        }
        if (at->bend != 0) {
            bend_joint(own, e, j, N, M);
            for (int a = 0; a < 3; a++)
                put(&r->rotation[j][a], &rates->rotation[j][a], squares, own[a]);
        }
        if (some || at->yields)
            put(&r->angle[j], &rates->angle[j], squares,
                at->twist * (DOT(at->into_N, M) + DOT(at->into_M, N)));
        for (int a = 0; a < 3; a++) {
            M[a] -= at->into_M[a] * angle;
            N[a] += at->into_N[a] * angle;
        }
    }
}

/* `some`: as of answer. */
PART void settle(mukca_posture_rates *rates, const mukca_equilibrium *e, bool some, double within)
{
    enum { ROUNDS = 8 };
    const int n = some ? e->n_yielding : e->n_joints;
    mukca_posture_rates r;
    for (int a = 0; a < 3; a++) r.base[a] = rates->base[a];
    for (int i = 0; i < n; i++) {
        const int j = some ? e->yielding[i] : i;
        r.angle[j] = rates->angle[j];
        if (!e->joint[j].tilts) continue;
        if (e->found)
            angular_velocity(rates->rotation[j], e->displacement.rotation[j], rates->rotation[j],
                             -1);
        for (int a = 0; a < 3; a++) r.rotation[j][a] = rates->rotation[j][a];
    }
    for (int round = 0; round < ROUNDS && e->loaded; round++) {
        lanes squares = ALL(0);
        double sum = 0;
        answer(rates, &r, &squares, e, some || round > 0);
        for (int l = 0; l < MUKCA_LANES; l++) sum += XYZ(&squares)[l];
        if (!(sum > within * within)) return;
    }
}

MUKCA_CLONES void mukca_equilibrium_settle(mukca_posture_rates *rates, const mukca_equilibrium *e,
                                           double within)
{
    settle(rates, e, false, within);
}

/* Load of the joints that yield and of the base. */
static void find_load(mukca_gravity_load *load, const mukca_equilibrium *e)
{
    for (int i = 0; i < e->n_yielding; i++) {
        const int j = e->yielding[i];
        const mukca_joint_posture *at = &e->joint[j];
        double moment[3];
        mukca_cross(moment, e->gravity, XYZ(at->first));
        load->torque[j] =
            at->slides ? -mukca_dot3(at->into_M, e->gravity) : mukca_dot3(XYZ(at->axis), moment);
        if (at->tilts) to_joint(load->moment[j], &at->frame, moment);
    }
    mukca_cross(load->base, e->gravity, XYZ(e->first));
}

/* An effect of the load that is no spring. */
static void add_other(mukca_displacement *d, mukca_equilibrium *e, const mukca_effect *f,
                      const double *axis, const mukca_joint_state *state)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[f->kind];
    double basis[MUKCA_MAX_TERMS][3] = {{0}}, *slope = &e->bend;
    ops->basis(basis, &(mukca_basis_input){.effect = f, .axis = axis, .state = state});
    mukca_effect_add(d, f, (const double(*)[3])basis);
    if (!e->loaded) return;
    if (ops->info.site == MUKCA_SITE_ANGLE) slope = &e->joint[f->joint].twist;
    if (ops->info.site == MUKCA_SITE_ROTATION) slope = &e->joint[f->joint].bend;
    *slope += f->coefficient[0] * ops->by_load(f, basis[0]);
}

/* What the effects add under the load at the posture, and their slopes by it. */
static void add_loaded(mukca_displacement *d, mukca_equilibrium *e, const mukca_effect_task *task)
{
    mukca_gravity_load load;
    mukca_joint_state state = task->state;
    if (e->loaded) {
        find_load(&load, e);
        state.torque = load.torque;
        state.moment = (const double(*)[3])load.moment;
        state.base_moment = load.base;
    }
    e->bend = e->spring;
    for (int a = 0; a < 3 && state.base_moment; a++) d->base[a] += e->spring * state.base_moment[a];
    d->any_rotation |= e->spring != 0;
    for (int i = 0; i < e->n_yielding; i++) {
        const int j = e->yielding[i];
        mukca_joint_posture *at = &e->joint[j];
        at->twist = at->spring;
        at->bend = at->blade;
        if (state.torque) d->q[j] += at->spring * state.torque[j];
        if (at->blade == 0 || !state.moment) continue;
        d->any_rotation = true;
        const double *axis = task->geometry->axis[task->chain->joint_element[j]];
        const double *moment = state.moment[j];
        const double along = mukca_dot3(moment, axis);
        for (int a = 0; a < 3; a++) d->rotation[j][a] += at->blade * (moment[a] - along * axis[a]);
    }
    for (int i = 0; i < e->n_other; i++) {
        const mukca_effect *f = task->effects + e->other[i];
        add_other(d, e, f, mukca_effect_axis(f, task->chain), &state);
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

/* What the first lane has. */
#define FIRST(rate) (*(const double *)(const void *)&(rate))

/* A part of what was, in `was`, and of what is now: their difference, and what was. */
PART void take_difference(lanes *was, double *now, double *size)
{
    const double before = FIRST(*was), change = *now - before;
    if (fabs(change) > *size) *size = fabs(change);
    *now = before;
    *was = ALL(change);
}

/* A step of Newton's method: the displacement changes by the difference from what the effects add
 * under the load of the posture, with the answers to it.  Returns the largest part of the
 * difference, rad or m. */
PART double step(mukca_equilibrium *e, const mukca_effect_task *task,
                 const mukca_displacement *unloaded)
{
    mukca_displacement *d = &e->displacement;
    mukca_posture_rates r; /* what was, then the difference, then with the answers */
    double size = 0;
    for (int a = 0; a < 3; a++) {
        r.base[a] = ALL(d->base[a]);
        d->base[a] = unloaded->base[a];
        d->tip[a] = unloaded->tip[a];
    }
    for (int i = 0; i < e->n_yielding; i++) {
        const int j = e->yielding[i];
        r.angle[j] = ALL(d->q[j]);
        d->q[j] = unloaded->q[j];
        for (int a = 0; a < 3 && e->joint[j].tilts; a++) {
            r.rotation[j][a] = ALL(d->rotation[j][a]);
            d->rotation[j][a] = unloaded->rotation[j][a];
        }
    }
    add_loaded(d, e, task);
    for (int a = 0; a < 3; a++) take_difference(&r.base[a], &d->base[a], &size);
    for (int i = 0; i < e->n_yielding; i++) {
        const int j = e->yielding[i];
        double change[3];
        take_difference(&r.angle[j], &d->q[j], &size);
        if (!e->joint[j].tilts) continue;
        for (int a = 0; a < 3; a++) {
            take_difference(&r.rotation[j][a], &d->rotation[j][a], &size);
            change[a] = FIRST(r.rotation[j][a]);
        }
        to_base(change, &e->joint[j].frame, change);
        for (int a = 0; a < 3; a++) r.rotation[j][a] = ALL(change[a]);
    }
    if (!(size > rest)) return size;
    settle(&r, e, true, size * size + rest);
    for (int a = 0; a < 3; a++) d->base[a] += FIRST(r.base[a]);
    for (int i = 0; i < e->n_yielding; i++) {
        const int j = e->yielding[i];
        double turned[3];
        d->q[j] += FIRST(r.angle[j]);
        if (!e->joint[j].tilts) continue;
        for (int a = 0; a < 3; a++) turned[a] = FIRST(r.rotation[j][a]);
        to_joint(turned, &e->joint[j].frame, turned);
        for (int a = 0; a < 3; a++) d->rotation[j][a] += turned[a];
    }
    return size;
}

/* Sort the effects that depend on the load by joints, and into springs and others. */
static void start(mukca_equilibrium *e, const mukca_effect_task *task)
{
    const mukca_chain *chain = task->chain;
    bool some = false;
    memcpy(e->gravity, chain->gravity, sizeof e->gravity);
    e->found = false; /* rates are those of rotation vectors: right enough for Newton's method */
    e->n_joints = chain->n_joints;
    e->n_yielding = e->n_other = 0;
    e->spring = 0;
    for (int j = 0; j < chain->n_joints; j++) {
        mukca_joint_posture *at = &e->joint[j];
        at->slides = task->geometry->type[chain->joint_element[j]] == MUKCA_PRISMATIC;
        at->yields = at->tilts = false;
        at->spring = at->blade = at->bend = 0;
    }
    for (int i = 0; i < task->n_effects; i++) {
        const mukca_effect *f = &task->effects[i];
        const mukca_effect_info *info = mukca_effect_table[f->kind];
        double *spring = &e->spring;
        if (!(info->needs & MUKCA_NEEDS_MASSES)) continue;
        some = true;
        if (f->joint >= 0) {
            mukca_joint_posture *at = &e->joint[f->joint];
            spring = info->site == MUKCA_SITE_ROTATION ? &at->blade : &at->spring;
            at->yields = true;
            at->tilts |= info->site == MUKCA_SITE_ROTATION;
        }
        if (info->traits & MUKCA_TRAIT_ELASTIC)
            *spring -= f->coefficient[0];
        else
            e->other[e->n_other++] = (unsigned char)i;
    }
    for (int j = 0; j < chain->n_joints; j++)
        if (e->joint[j].yields) e->yielding[e->n_yielding++] = (unsigned char)j;
    e->loaded = some && !task->state.torque;
}

MUKCA_CLONES void mukca_equilibrium_find(mukca_equilibrium *e, mukca_effect_slopes *slopes,
                                         const mukca_effect_task *task)
{
    enum { ROUNDS = 8 }; /* usually 2: Newton's method, from 1 mrad off */
    mukca_displacement unloaded;
    double size = 0, before = 0, first = 0;
    start(e, task);
    mukca_effects_unloaded(&unloaded, slopes, task);
    copy(&e->displacement, &unloaded, e->n_joints);
    if (!e->loaded) add_loaded(&e->displacement, e, task); /* under torques that are given */
    for (int round = 0;; round++) {
        set_posture(e, task);
        /* The next step is smaller than this at least as this than the one before.  What the method
         * leaves out shrinks by the rotations times the deflection per rad: both are some `first`.
         * Slopes that change with the load are those of the posture of the last step. */
        if (!e->loaded || round == ROUNDS) return;
        if (size * size < rest * before && size * first * first < rest &&
            !(slopes && e->n_other > 0))
            return;
        before = size;
        size = step(e, task, &unloaded);
        if (!(size > rest)) return;
        if (round == 0) first = size;
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
