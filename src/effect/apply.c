/* Displacement of the arm by its effects. */
#include <math.h>
#include <string.h>

#include "effect/catalogue.h"
#include "math/four.h"
#include "math/sincos.h"
#include "model/turn.h"
#include "mukca/gravity.h"

/* All terms of an effect := 0, by vector stores: for so few bytes gcc replaces memset by an
 * instruction that is slower than most effects. */
MUKCA_INLINE void clear_terms(double terms[MUKCA_MAX_TERMS][3])
{
    double *all = (double *)(void *)terms;
    for (int i = 0; i < 3 * MUKCA_MAX_TERMS; i += MUKCA_LANES) STORE_LANES(all + i, (lanes){0});
}

/* into += coefficients times rows of basis, n components each. */
static inline void add_terms(double *into, int n, const mukca_effect *effect,
                             const double basis[][3])
{
    for (int t = 0; t < effect->terms; t++)
        for (int i = 0; i < n; i++) into[i] += effect->coefficient[t] * basis[t][i];
}

static inline void add_basis(mukca_displacement *d, mukca_effect_site site,
                             const mukca_effect *effect, const double basis[][3])
{
    if (site == MUKCA_SITE_ANGLE) add_terms(&d->q[effect->joint], 1, effect, basis);
    if (site == MUKCA_SITE_ROTATION) add_terms(d->rotation[effect->joint], 3, effect, basis);
    if (site == MUKCA_SITE_BASE) add_terms(d->base, 3, effect, basis);
    if (site == MUKCA_SITE_TIP) add_terms(d->tip, 3, effect, basis);
    d->any_rotation |= site == MUKCA_SITE_ROTATION || site == MUKCA_SITE_BASE;
}

static void add_direction(mukca_displacement *displacement, const mukca_effect *effect,
                          const mukca_chain *chain, const mukca_joint_state *state)
{
    double direction[MUKCA_MAX_JOINTS];
    mukca_effect_direction(direction, chain->n_joints, effect, state);
    for (int i = 0; i < chain->n_joints; i++)
        displacement->q[i] += effect->coefficient[0] * direction[i];
}

/* Derivatives of one effect by the joint angles, from its basis. */
static inline void add_slopes(mukca_effect_slopes *slopes, const mukca_effect_ops *ops,
                              int n_joints, const mukca_basis_input *in, const double basis[][3])
{
    const mukca_effect *e = in->effect;
    double slope[MUKCA_MAX_TERMS][3];
    clear_terms(slope);
    const int by = ops->by_angle(slope, in, basis);
    if (ops->direction)
        for (int j = 0; j < n_joints; j++) slopes->angle[j][1] += e->coefficient[0] * slope[0][0];
    else if (ops->info.site == MUKCA_SITE_ROTATION)
        slopes->rotates = true,
        add_terms(slopes->rotation[e->joint], 3, e, (const double(*)[3])slope);
    else
        add_terms(&slopes->angle[e->joint][1 + by], 1, e, (const double(*)[3])slope);
}

/* Displacement and derivatives by one effect; sine[2], cosine[2]: of a periodic effect's angles.
 */
static void add_effect(mukca_displacement *d, mukca_effect_slopes *slopes,
                       const mukca_effect_task *task, const mukca_effect *e, const double *sine,
                       const double *cosine)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[e->kind];
    const double *axis =
        e->joint < 0 ? NULL : task->geometry->axis[task->chain->joint_element[e->joint]];
    const mukca_basis_input in = {
        .effect = e, .axis = axis, .state = &task->state, .sine = sine, .cosine = cosine};
    double basis[MUKCA_MAX_TERMS][3];
    clear_terms(basis);
    if (ops->direction) add_direction(d, e, task->chain, &task->state);
    if (ops->basis) {
        ops->basis(basis, &in);
        add_basis(d, ops->info.site, e, (const double(*)[3])basis);
    }
    if (slopes && ops->by_angle)
        add_slopes(slopes, ops, task->chain->n_joints, &in, (const double(*)[3])basis);
}

/* Load-independent effects.  Returns whether there are others. */
static bool apply_unloaded(mukca_displacement *displacement, mukca_effect_slopes *slopes,
                           const mukca_effect_task *task)
{
    enum { TOGETHER = 4 }; /* periodic effects per call of mukca_sincos(): all lanes */
    const mukca_effect *waiting[TOGETHER];
    double angle[TOGETHER], sine[TOGETHER], cosine[TOGETHER];
    joint_angles bare;
    bool loaded = false;
    int n = 0;
    const int joints = task->chain->n_joints;
    memset(displacement, 0, sizeof *displacement);
    if (slopes) slopes->rotates = false;
    mukca_joint_angles_set(&bare, task->geometry, task->state.q, NULL);
    for (int j = 0; j < joints && slopes; j++) {
        const double axis[3] = {0, 1, 0}, none[3] = {0};
        memcpy(slopes->angle[j], axis, sizeof axis);
        memcpy(slopes->rotation[j], none, sizeof none);
    }
    for (int i = 0; i <= task->n_effects; i++) {
        const mukca_effect *e = task->effects + i;
        if (i < task->n_effects) {
            const mukca_effect_info *info = mukca_effect_table[e->kind];
            if (info->needs & MUKCA_NEEDS_MASSES) {
                loaded = true;
                continue;
            }
            if (!(info->traits & MUKCA_TRAIT_PERIODIC)) {
                add_effect(displacement, slopes, task, e, NULL, NULL);
                continue;
            }
            waiting[n] = e;
            angle[n++] = (e->variant.order ? e->variant.order : 1) * bare.q[e->joint];
        }
        if (n == 0 || (n < TOGETHER && i < task->n_effects)) continue;
        mukca_sincos(sine, cosine, angle, n);
        for (int k = 0; k < n; k++) {
            const int j = waiting[k]->joint;
            const double s[2] = {sine[k], bare.s[j]}, c[2] = {cosine[k], bare.c[j]};
            add_effect(displacement, slopes, task, waiting[k], s, c);
        }
        n = 0;
    }
    return loaded;
}

/* A round of the fixed point multiplies the error by the deflection per rad of motion, 0.003 to
 * 0.01 in real arms and 0.04 in one on a column: these take four rounds, after which their tips are
 * within 0.1 um. */
enum { MOST_ROUNDS = 16 };
static const double settled = 1e-7; /* rad or m, of a round's change */

/* Largest difference of two displacements, rad or m. */
static double difference(const mukca_displacement *a, const mukca_displacement *b, int joints)
{
    double most = 0;
    for (int i = 0; i < 3; i++) most = fmax(most, fabs(a->base[i] - b->base[i]));
    for (int j = 0; j < joints; j++) {
        most = fmax(most, fabs(a->q[j] - b->q[j]));
        for (int i = 0; i < 3; i++) most = fmax(most, fabs(a->rotation[j][i] - b->rotation[j][i]));
    }
    return most;
}

void mukca_effects_apply(mukca_displacement *displacement, mukca_effect_slopes *slopes,
                         const mukca_effect_task *task)
{
    mukca_gravity_load load;
    mukca_masses masses;
    mukca_effect_task loaded = *task;
    if (!apply_unloaded(displacement, slopes, task)) return;
    const mukca_displacement unloaded = *displacement;
    mukca_chain_masses(&masses, task->chain, NULL, task->state.payload_kg);
    loaded.state.torque = load.torque;
    loaded.state.moment = (const double(*)[3])load.moment;
    loaded.state.base_moment = load.base;
    mukca_displacement before;
    int rounds = 0;
    do {
        mukca_chain_load(&load, task->chain, task->geometry, task->state.q, displacement, &masses);
        before = *displacement;
        *displacement = unloaded;
        for (int i = 0; i < task->n_effects; i++)
            if (mukca_effect_table[task->effects[i].kind]->needs & MUKCA_NEEDS_MASSES)
                add_effect(displacement, NULL, &loaded, &task->effects[i], NULL, NULL);
    } while (++rounds < MOST_ROUNDS &&
             difference(displacement, &before, task->chain->n_joints) > settled);
}

void mukca_effects_displacement(mukca_displacement *displacement, const mukca_effect *effects,
                                int n, const mukca_chain *chain, const mukca_geometry *geometry,
                                const double *q, const mukca_joint_state *state)
{
    mukca_effect_task task = {
        .effects = effects, .n_effects = n, .chain = chain, .geometry = geometry};
    if (state) task.state = *state;
    if (!state) task.state.placement = -1;
    task.state.q = q;
    mukca_effects_apply(displacement, NULL, &task);
}
