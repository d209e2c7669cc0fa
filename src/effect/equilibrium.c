/* Static equilibrium of the arm under load, with its effects: Newton's method. */
#include "effect/equilibrium.h"

#include <math.h>
#include <string.h>

#include "effect/catalogue.h"
#include "math/sincos.h"
#include "mukca/gravity.h"

/* Move the joints to q + by; update the sines and cosines from the previous ones. */
PART void move_angles(joint_angles *at, const double *q, const double *by, int n)
{
    double turn[WHOLE_JOINTS];
    lane_bits wide = {0};
    for (int j = 0; j < n; j++) {
        const double to = q[j] + by[j];
        turn[j] = to - at->q[j];
        at->moved[j] = to;
    }
    for (int j = n; j % MUKCA_LANES; j++) turn[j] = 0;
    at->q = at->moved;
    for (int j = 0; j < n; j += MUKCA_LANES) {
        const lanes s = LOAD_LANES(at->s + j), c = LOAD_LANES(at->c + j);
        const lanes x = LOAD_LANES(turn + j), t = x * x;
        /* up to 1/32 rad the next terms of the series are below 3e-17 */
        const lanes sine = x - x * t * (1.0 / 6 - t * (1.0 / 120 - t * (1.0 / 5040)));
        const lanes back = t * (0.5 - t * (1.0 / 24 - t * (1.0 / 720)));
        wide |= NOT_WITHIN(t, 0x1p-10);
        STORE_LANES(at->s + j, s + (c * sine - s * back));
        STORE_LANES(at->c + j, c - (s * sine + c * back));
    }
    if (ANY_LANE(wide) && !mukca_sincos_near(at->s, at->c, at->moved, n))
        at->s[0] = at->c[0] = (double)NAN;
}

/* Contributions of a joint to M and N; `kg`: mass of all distal bodies. */
PART void set_contributions(mukca_joint_posture *joint, double kg, const lanes *gravity)
{
    columns_cross(joint->into_M, joint->axis, joint->first);
    columns_cross(joint->into_N, joint->axis, gravity);
    for (int r = 0; r < ROWS && joint->slides; r++) {
        joint->into_M[r] = kg * joint->axis[r];
        joint->into_N[r] = (lanes){0};
    }
}

/* From base to tip, frames and first moments of the bodies between a joint and the next; then from
 * tip to base, first moments of all distal bodies. */
PART void set_posture(mukca_equilibrium *e, const mukca_effect_task *task, const joint_angles *at)
{
    const mukca_geometry *g = task->geometry;
    const mukca_displacement *d = &e->displacement;
    double kg[MUKCA_MAX_ELEMENTS], first[MUKCA_MAX_ELEMENTS][3], total = 0;
    lanes sum[ROWS] = {0}, moment[ROWS], *body = e->first; /* about the base's origin */
    columns F;
    mukca_chain_masses(kg, first, task->chain, NULL, task->state.payload_kg);
    columns_base(&F, d);
    for (int k = 0; k < g->n_elements; k++) {
        const int j = g->joint[k];
        columns_enter(&F, g, k);
        if (j >= 0) {
            mukca_joint_posture *joint = &e->joint[j];
            joint->slides = g->type[k] == MUKCA_PRISMATIC;
            if (joint->rotates) columns_bend(&F, d->rotation[j]);
            for (int c = 0; c < 4; c++)
                for (int r = 0; r < ROWS; r++) joint->frame.column[c][r] = F.column[c][r];
            columns_vector(joint->axis, &F, g->axis[k]);
            columns_turn(&F, g, k, at);
            for (int r = 0; r < ROWS; r++) body[r] = sum[r], sum[r] = (lanes){0};
            body = joint->first;
        }
        columns_vector(moment, &F, first[k]);
        for (int r = 0; r < ROWS; r++) sum[r] += moment[r] + kg[k] * F.column[3][r];
    }
    columns_move(&F, d->tip);
    for (int c = 0; c < 4; c++)
        for (int r = 0; r < ROWS; r++) e->tip.column[c][r] = F.column[c][r];
    for (int r = 0; r < ROWS; r++) body[r] = sum[r], sum[r] = (lanes){0};
    for (int k = g->n_elements - 1; k >= 0; k--) {
        const int j = g->joint[k];
        total += kg[k];
        if (j < 0) continue;
        mukca_joint_posture *joint = &e->joint[j];
        for (int r = 0; r < ROWS; r++) {
            sum[r] += joint->first[r];
            joint->first[r] = sum[r] - total * joint->frame.column[3][r];
        }
        set_contributions(joint, total, e->gravity);
    }
    for (int r = 0; r < ROWS; r++) e->first[r] += sum[r];
}

/* Gravity load of the base and of the joints with load-dependent effects. */
PART void find_load(mukca_gravity_load *load, const mukca_equilibrium *e)
{
    lanes moment[ROWS];
    for (int i = 0; i < e->n_deflecting; i++) {
        const int j = e->deflecting[i];
        const mukca_joint_posture *at = &e->joint[j];
        load->torque[j] =
            at->slides ? -columns_dot(at->into_M, e->gravity) : columns_dot(at->into_N, at->first);
        if (!at->tilts) continue;
        columns_cross(moment, e->gravity, at->first);
        to_joint(load->moment[j], &at->frame, XYZ(moment));
    }
    mukca_cross(load->base, XYZ(e->gravity), XYZ(e->first));
}

/* Add an inelastic load-dependent effect, and its derivative by the load. */
static void add_inelastic(mukca_deflection *y, mukca_equilibrium *e, const mukca_effect *f,
                          const double *axis, const mukca_joint_state *state)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[f->kind];
    const bool turns = ops->info.site == MUKCA_SITE_ROTATION,
               one = ops->info.site == MUKCA_SITE_ANGLE;
    double basis[MUKCA_MAX_TERMS][3];
    clear_terms(basis);
    double *into = one ? &y->angle[f->joint] : turns ? y->rotation[f->joint] : y->base;
    double *slope = one ? &e->joint[f->joint].twist : turns ? &e->joint[f->joint].bend : &e->bend;
    ops->basis(basis, &(mukca_basis_input){.effect = f, .axis = axis, .state = state});
    for (int t = 0; t < f->terms; t++)
        for (int a = 0; a < (one ? 1 : 3); a++) into[a] += f->coefficient[t] * basis[t][a];
    *slope += f->coefficient[0] * ops->by_load(f, basis[0]);
}

/* y := deflections under the present load; their derivatives by the load. */
PART void find_deflection(mukca_deflection *y, mukca_equilibrium *e, const mukca_effect_task *task)
{
    mukca_gravity_load load;
    mukca_joint_state state = task->state;
    find_load(&load, e);
    state.torque = load.torque;
    state.moment = (const double(*)[3])load.moment;
    state.base_moment = load.base;
    e->bend = e->spring;
    for (int a = 0; a < 3; a++) y->base[a] = e->spring * load.base[a];
    for (int i = 0; i < e->n_deflecting; i++) {
        const int j = e->deflecting[i];
        mukca_joint_posture *at = &e->joint[j];
        at->twist = at->spring;
        at->bend = at->blade;
        y->angle[j] = at->spring * load.torque[j];
        if (!at->tilts) continue;
        const double *axis = task->geometry->axis[task->chain->joint_element[j]];
        const double *moment = load.moment[j], along = mukca_dot3(moment, axis);
        for (int a = 0; a < 3; a++) y->rotation[j][a] = at->blade * (moment[a] - along * axis[a]);
    }
    for (int i = 0; i < e->n_inelastic; i++) {
        const mukca_effect *f = task->effects + e->inelastic[i];
        add_inelastic(y, e, f, effect_axis(f, task), &state);
    }
}

PART void clear(mukca_deflection *y, const mukca_equilibrium *e)
{
    for (int a = 0; a < 3; a++) y->base[a] = 0;
    for (int i = 0; i < e->n_deflecting; i++) {
        const int j = e->deflecting[i];
        y->angle[j] = 0;
        for (int a = 0; a < 3; a++) y->rotation[j][a] = 0;
    }
}

/* y and the displacement += change. */
PART void add_change(mukca_deflection *y, mukca_equilibrium *e, const mukca_deflection *change)
{
    mukca_displacement *d = &e->displacement;
    for (int a = 0; a < 3; a++) {
        y->base[a] += change->base[a];
        d->base[a] += change->base[a];
    }
    for (int i = 0; i < e->n_deflecting; i++) {
        const int j = e->deflecting[i];
        y->angle[j] += change->angle[j];
        d->q[j] += change->angle[j];
        for (int a = 0; a < 3 && e->joint[j].tilts; a++) {
            y->rotation[j][a] += change->rotation[j][a];
            d->rotation[j][a] += change->rotation[j][a];
        }
    }
}

/* y -= by; size := max(size, |y|). */
MUKCA_INLINE void subtract_part(double *y, double by, double *size)
{
    *y -= by;
    if (fabs(*y) > *size) *size = fabs(*y);
}

/* y -= by.  Returns the largest absolute component of y, rad or m. */
PART double subtract(mukca_deflection *y, const mukca_equilibrium *e, const mukca_deflection *by)
{
    double size = 0;
    for (int a = 0; a < 3; a++) subtract_part(&y->base[a], by->base[a], &size);
    for (int i = 0; i < e->n_deflecting; i++) {
        const int j = e->deflecting[i];
        subtract_part(&y->angle[j], by->angle[j], &size);
        for (int a = 0; a < 3 && e->joint[j].tilts; a++)
            subtract_part(&y->rotation[j][a], by->rotation[j][a], &size);
    }
    return size;
}

/* out[ROWS] := rotation of a joint's frame by a change r of its rotation vector b, to second order:
 * r - b x r / 2 in the coordinates after the rotation. */
PART void frame_rotation(lanes *out, const mukca_equilibrium *e, const mukca_deflection *change,
                         int j)
{
    const double *r = change->rotation[j];
    double bent[3];
    mukca_cross(bent, e->displacement.rotation[j], r);
    for (int a = 0; a < 3; a++) bent[a] = r[a] - 0.5 * bent[a];
    columns_vector(out, &e->joint[j].frame, bent);
}

/* f := f + w x f for n columns of a frame. */
PART void turn_columns(columns *f, int n, const lanes *w)
{
    lanes by[ROWS] = {0};
    for (int c = 0; c < n; c++) {
        columns_cross(by, w, f->column[c]);
        for (int r = 0; r < ROWS; r++) f->column[c][r] += by[r];
    }
}

/* Update the first moments by the motions of the distal joints, from tip to base; their rotation by
 * the proximal joints and the joint itself is already included. */
PART void move_moments(mukca_equilibrium *e, const mukca_deflection *change)
{
    lanes M[ROWS] = {0}, part[ROWS], tilt[ROWS];
    for (int j = e->n_joints - 1; j >= 0; j--) {
        mukca_joint_posture *at = &e->joint[j];
        const double angle = at->deflects ? change->angle[j] : 0;
        for (int r = 0; r < ROWS; r++) part[r] = at->into_M[r] * angle;
        if (at->tilts) {
            frame_rotation(tilt, e, change, j);
            columns_add_cross(part, tilt, at->first);
        }
        for (int r = 0; r < ROWS; r++) at->first[r] += M[r], M[r] += part[r];
        if (at->slides) continue;
        columns_cross(at->into_M, at->axis, at->first);
        columns_cross(at->into_N, at->axis, e->gravity);
    }
    for (int r = 0; r < ROWS; r++) e->first[r] += M[r];
}

/* Move the tip, and with `whole` the entire posture, by the last change, small enough for first
 * order. */
PART void move_posture(mukca_equilibrium *e, const mukca_deflection *change, bool whole)
{
    lanes v[ROWS] = {0}, w[ROWS] = {0}, turn[ROWS], column[ROWS] = {0};
    double bent[3];
    mukca_cross(bent, e->displacement.base, change->base);
    for (int a = 0; a < 3; a++) ((double *)w)[a] = change->base[a] + 0.5 * bent[a];
    if (whole) columns_add_cross(e->first, w, e->first);
    for (int j = 0; j < e->n_joints; j++) {
        mukca_joint_posture *at = &e->joint[j];
        lanes *p = at->frame.column[3];
        if (!whole && !at->deflects) continue;
        if (whole) {
            columns_cross(column, w, p);
            for (int r = 0; r < ROWS; r++) p[r] += v[r] + column[r];
        }
        if (at->tilts) {
            frame_rotation(turn, e, change, j);
            columns_add_cross(v, p, turn);
            for (int r = 0; r < ROWS; r++) w[r] += turn[r];
        }
        if (whole) {
            columns_add_cross(at->axis, w, at->axis);
            if (at->rotates) turn_columns(&at->frame, 3, w);
        }
        if (at->deflects) {
            for (int r = 0; r < ROWS; r++) {
                turn[r] = change->angle[j] * at->axis[r];
                if (at->slides) v[r] += turn[r], turn[r] *= 0;
            }
            columns_add_cross(v, p, turn);
            for (int r = 0; r < ROWS; r++) w[r] += turn[r];
        }
        if (!whole) continue;
        columns_add_cross(at->first, w, at->first);
        if (at->slides) columns_add_cross(at->into_M, w, at->into_M);
    }
    if (whole) move_moments(e, change);
    turn_columns(&e->tip, 4, w);
    for (int r = 0; r < ROWS; r++) e->tip.column[3][r] += v[r];
}

/* Sort the load-dependent effects by joint, and into elastic and inelastic ones. */
static void sort_effects(mukca_equilibrium *e, const mukca_effect_task *task)
{
    const mukca_chain *chain = task->chain;
    memset(e->gravity, 0, sizeof e->gravity);
    for (int i = 0; i < 3; i++) ((double *)e->gravity)[i] = chain->gravity[i];
    e->n_joints = chain->n_joints;
    e->n_deflecting = e->n_inelastic = 0;
    e->spring = e->bend = 0;
    e->tilts = e->loaded = false;
    for (int j = 0; j < chain->n_joints; j++) {
        mukca_joint_posture *at = &e->joint[j];
        at->rotates = at->deflects = at->tilts = false;
        at->spring = at->blade = at->bend = 0;
    }
    for (int i = 0; i < task->n_effects; i++) {
        const mukca_effect *f = &task->effects[i];
        const mukca_effect_info *info = mukca_effect_table[f->kind];
        double *spring = &e->spring;
        if (info->site == MUKCA_SITE_ROTATION) e->joint[f->joint].rotates = true;
        if (!(info->needs & MUKCA_NEEDS_MASSES)) continue;
        e->loaded = true;
        e->tilts |= info->site != MUKCA_SITE_ANGLE;
        if (f->joint >= 0) {
            mukca_joint_posture *at = &e->joint[f->joint];
            spring = info->site == MUKCA_SITE_ROTATION ? &at->blade : &at->spring;
            at->deflects = true;
            at->tilts |= info->site == MUKCA_SITE_ROTATION;
        }
        if (info->traits & MUKCA_TRAIT_ELASTIC)
            *spring -= f->coefficient[0];
        else
            e->inelastic[e->n_inelastic++] = (unsigned char)i;
    }
    for (int j = 0; j < chain->n_joints; j++)
        if (e->joint[j].deflects) e->deflecting[e->n_deflecting++] = (unsigned char)j;
}

/* Tolerance, rad or m: seven joints with their rotations keep the tip within 1e-12. */
static const double tolerance = 1e-13;

/* Sizes of the steps so far. */
typedef struct {
    double first, before, last;
} steps;

/* One step of Newton's method: the displacement changes by the deflection under the load of this
 * posture minus the present deflection y, plus the response to this change.  Returns true at
 * equilibrium; then the tip, and with `whole` the posture, are updated. */
PART bool step(mukca_equilibrium *e, mukca_deflection *y, steps *size, bool whole,
               const mukca_effect_task *task)
{
    mukca_deflection change;
    find_deflection(&change, e, task);
    size->before = size->last;
    size->last = subtract(&change, e, y);
    if (size->before == 0) size->first = size->last;
    if (!(size->last > tolerance)) return true;
    /* A step of Newton's method leaves an error of order size^2.  The response is computed to this
     * accuracy: a round multiplies its error by the deflection per rad, at most ten times `first`,
     * or 0.01 in a posture of little deflection. */
    const double error = size->last * size->last + tolerance;
    mukca_equilibrium_settle(&change, e, error / (10 * size->first + 0.01));
    add_change(y, e, &change);
    /* The next step is at most last^2 / before.  The terms neglected in the response are smaller
     * than this step by the rotations times the deflection per rad, both of order `first`. */
    const bool found = size->last * size->last < tolerance * size->before &&
                       size->last * size->first * size->first < tolerance;
    if (found) move_posture(e, &change, whole);
    return found;
}

MUKCA_CLONES void mukca_equilibrium_find(mukca_equilibrium *e, mukca_effect_slopes *slopes,
                                         const mukca_effect_task *task)
{
    enum { ROUNDS = 8 }; /* usually 2, from an error of 1 mrad */
    mukca_displacement *d = &e->displacement;
    mukca_deflection y;
    joint_angles at;
    steps size = {0};
    bool found = false;
    sort_effects(e, task);
    mukca_effects_unloaded(d, slopes, &at, task);
    d->any_rotation |= e->tilts;
    clear(&y, e);
    for (int round = 0; round < ROUNDS && !found; round++) {
        move_angles(&at, task->state.q, d->q, e->n_joints);
        set_posture(e, task, &at);
        found = !e->loaded || step(e, &y, &size, slopes != NULL, task);
    }
    if (slopes && e->n_inelastic > 0) find_deflection(&y, e, task); /* derivatives by the load */
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
    memset(&at.displacement, 0, sizeof at.displacement);
    mukca_equilibrium_find(&at, NULL, &task);
    *displacement = at.displacement;
}
