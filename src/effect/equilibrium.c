/* The arm at rest under its load, with its effects. */
#include "effect/equilibrium.h"

#include <math.h>
#include <string.h>

#include "effect/catalogue.h"
#include "mukca/gravity.h"

/* A vector in base coordinates, in a joint's frame. */
static void to_joint(double out[3], const columns *F, const double v[3])
{
    const double x = v[0], y = v[1], z = v[2];
    for (int c = 0; c < 3; c++)
        out[c] = COLUMN(F, c, 0) * x + COLUMN(F, c, 1) * y + COLUMN(F, c, 2) * z;
}

/* The parts of a joint that carries `kg`. */
PART void set_parts(mukca_joint_posture *joint, double kg, const lanes *gravity)
{
    columns_cross(joint->into_M, joint->axis, joint->first);
    columns_cross(joint->into_N, joint->axis, gravity);
    for (int r = 0; r < ROWS && joint->slides; r++) {
        joint->into_M[r] = kg * joint->axis[r];
        joint->into_N[r] = ALL(0);
    }
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

/* Load of the joints that yield and of the base. */
static void find_load(mukca_gravity_load *load, const mukca_equilibrium *e)
{
    for (int i = 0; i < e->n_yielding; i++) {
        const int j = e->yielding[i];
        const mukca_joint_posture *at = &e->joint[j];
        double moment[3];
        mukca_cross(moment, XYZ(e->gravity), XYZ(at->first));
        load->torque[j] = at->slides ? -mukca_dot3(XYZ(at->into_M), XYZ(e->gravity))
                                     : mukca_dot3(XYZ(at->axis), moment);
        if (at->tilts) to_joint(load->moment[j], &at->frame, moment);
    }
    mukca_cross(load->base, XYZ(e->gravity), XYZ(e->first));
}

/* An effect of the load that is no spring. */
static void add_other(mukca_displacement *d, mukca_equilibrium *e, const mukca_effect *f,
                      const double *axis, const mukca_joint_state *state)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[f->kind];
    double basis[MUKCA_MAX_TERMS][3], *slope = &e->bend;
    memset(basis, 0, (size_t)f->terms * sizeof *basis);
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

/* A part of what was, in `was`, and of what is now: their difference, and what was. */
PART void take_difference(lanes *was, double *now, double *size)
{
    const double before = FIRST(*was), change = *now - before;
    if (fabs(change) > *size) *size = fabs(change);
    *now = before;
    *was = ALL(change);
}

/* r := what the effects add under the load of the posture, minus what they did.  Returns its
 * largest part, rad or m. */
PART double find_difference(mukca_posture_rates *r, mukca_equilibrium *e,
                            const mukca_effect_task *task, const mukca_displacement *unloaded)
{
    mukca_displacement *d = &e->displacement;
    double size = 0;
    for (int a = 0; a < 3; a++) {
        r->base[a] = ALL(d->base[a]);
        d->base[a] = unloaded->base[a];
        d->tip[a] = unloaded->tip[a];
    }
    for (int i = 0; i < e->n_yielding; i++) {
        const int j = e->yielding[i];
        r->angle[j] = ALL(d->q[j]);
        d->q[j] = unloaded->q[j];
        for (int a = 0; a < 3 && e->joint[j].tilts; a++) {
            r->rotation[j][a] = ALL(d->rotation[j][a]);
            d->rotation[j][a] = unloaded->rotation[j][a];
        }
    }
    add_loaded(d, e, task);
    for (int a = 0; a < 3; a++) take_difference(&r->base[a], &d->base[a], &size);
    for (int i = 0; i < e->n_yielding; i++) {
        const int j = e->yielding[i];
        double change[3];
        take_difference(&r->angle[j], &d->q[j], &size);
        if (!e->joint[j].tilts) continue;
        for (int a = 0; a < 3; a++) {
            take_difference(&r->rotation[j][a], &d->rotation[j][a], &size);
            change[a] = FIRST(r->rotation[j][a]);
        }
        to_base(change, &e->joint[j].frame, change);
        for (int a = 0; a < 3; a++) r->rotation[j][a] = ALL(change[a]);
    }
    return size;
}

/* c += a x b */
static void add_cross(double c[3], const double a[3], const double b[3])
{
    double cross[3];
    mukca_cross(cross, a, b);
    for (int i = 0; i < 3; i++) c[i] += cross[i];
}

/* The tip moves by small v + w x p, exact to the squares. */
static void move_tip(mukca_frame *tip, const double v[3], const double w[3])
{
    add_cross(tip->p, w, tip->p);
    for (int i = 0; i < 3; i++) tip->p[i] += v[i];
    for (int c = 0; c < 3; c++) {
        double column[3] = {tip->R[c], tip->R[3 + c], tip->R[6 + c]};
        add_cross(column, w, column);
        for (int i = 0; i < 3; i++) tip->R[3 * i + c] = column[i];
    }
}

/* The displacement += r, and the tip moves with it.  A rotation vector b that changes by r turns by
 * r - b x r / 2 after the rotation, r + b x r / 2 before it, exact to squares of b. */
static void add_rates(mukca_equilibrium *e, const mukca_posture_rates *r)
{
    mukca_displacement *d = &e->displacement;
    double v[3] = {0}, w[3], rate[3], bent[3];
    for (int a = 0; a < 3; a++) {
        w[a] = rate[a] = FIRST(r->base[a]);
        d->base[a] += rate[a];
        bent[a] = 0.5 * d->base[a];
    }
    add_cross(w, bent, rate);
    for (int i = 0; i < e->n_yielding; i++) {
        const int j = e->yielding[i];
        const mukca_joint_posture *at = &e->joint[j];
        const double *axis = XYZ(at->axis), *p = XYZ(at->frame.column[3]);
        const double angle = FIRST(r->angle[j]);
        double turn[3] = {angle * axis[0], angle * axis[1], angle * axis[2]};
        d->q[j] += angle;
        for (int a = 0; a < 3 && at->slides; a++) v[a] += turn[a], turn[a] = 0;
        if (at->tilts) {
            for (int a = 0; a < 3; a++) rate[a] = FIRST(r->rotation[j][a]), turn[a] += rate[a];
            to_joint(bent, &at->frame, rate);
            for (int a = 0; a < 3; a++) bent[a] = -0.5 * (d->rotation[j][a] += bent[a]);
            to_base(bent, &at->frame, bent);
            add_cross(turn, bent, rate);
        }
        add_cross(v, p, turn);
        for (int a = 0; a < 3; a++) w[a] += turn[a];
    }
    move_tip(&e->tip, v, w);
}

/* Sizes of the steps so far. */
typedef struct {
    double first, before, last;
} steps;

/* A step of Newton's method: the displacement changes by the difference from what the effects add
 * under the load of the posture, with the answers to it.  Returns whether that is the rest. */
PART bool step(mukca_equilibrium *e, const mukca_effect_task *task,
               const mukca_displacement *unloaded, steps *size)
{
    mukca_posture_rates r;
    size->before = size->last;
    size->last = find_difference(&r, e, task, unloaded);
    if (size->before == 0) size->first = size->last;
    if (!(size->last > rest)) return true;
    /* To what the method leaves, of the size's square: a round leaves the deflection per rad, which
     * is up to ten times `first`, or 0.01 where a posture happens to deflect less. */
    const double left = size->last * size->last + rest;
    mukca_equilibrium_settle(&r, e, true, left / (10 * size->first + 0.01));
    add_rates(e, &r);
    /* The next step is smaller than this at least as this than the one before.  What the method
     * leaves out shrinks by the rotations times the deflection per rad: both are some `first`. */
    return size->last * size->last < rest * size->before &&
           size->last * size->first * size->first < rest;
}

/* Sort the effects that depend on the load by joints, and into springs and others. */
static void start(mukca_equilibrium *e, const mukca_effect_task *task)
{
    const mukca_chain *chain = task->chain;
    bool some = false;
    memset(e->gravity, 0, sizeof e->gravity);
    for (int i = 0; i < 3; i++) ((double *)e->gravity)[i] = chain->gravity[i];
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
    steps size = {0};
    bool found = false;
    start(e, task);
    mukca_effects_unloaded(&unloaded, slopes, task);
    copy(&e->displacement, &unloaded, e->n_joints);
    if (!e->loaded) add_loaded(&e->displacement, e, task); /* under torques that are given */
    set_posture(e, task);
    for (int round = 0; round < ROUNDS && e->loaded && !found; round++) {
        found = step(e, task, &unloaded, &size);
        if (found && !slopes) return; /* the tip is there */
        set_posture(e, task);
    }
    if (e->loaded && e->n_other > 0) add_loaded(&unloaded, e, task); /* slopes by the load */
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
