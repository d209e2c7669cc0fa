/* Displacement of the arm by its effects. */
#include <math.h>
#include <string.h>

#include "effect/catalogue.h"
#include "mukca/gravity.h"

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

/* Derivatives of one effect by the joint angles, from its basis. */
static inline void add_slopes(mukca_effect_slopes *slopes, const mukca_effect_ops *ops,
                              int n_joints, const mukca_basis_input *in, const double basis[][3])
{
    const mukca_effect *e = in->effect;
    static const double none[MUKCA_MAX_TERMS][3] = {{0}};
    double slope[MUKCA_MAX_TERMS][3];
    memcpy(slope, none, sizeof slope); /* as in mukca_effect_basis() */
    const int by = ops->by_angle(slope, in, basis);
    if (ops->direction)
        for (int j = 0; j < n_joints; j++) slopes->angle[j][1] += e->coefficient[0] * slope[0][0];
    else if (ops->info.site == MUKCA_SITE_ROTATION)
        slopes->rotates = true,
        add_terms(slopes->rotation[e->joint], 3, e, (const double(*)[3])slope);
    else
        add_terms(&slopes->angle[e->joint][1 + by], 1, e, (const double(*)[3])slope);
}

/* Displacement and derivatives by one effect. */
static void add_effect(mukca_displacement *d, mukca_effect_slopes *slopes,
                       const mukca_effect_task *task, const mukca_effect *e)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[e->kind];
    const double *axis =
        e->joint < 0 ? NULL : task->geometry->axis[task->chain->joint_element[e->joint]];
    const mukca_basis_input in = {.effect = e, .axis = axis, .state = &task->state};
    double basis[MUKCA_MAX_TERMS][3], direction[MUKCA_MAX_JOINTS];
    const int joints = task->chain->n_joints;
    mukca_effect_basis(basis, e, axis, &task->state);
    if (ops->direction) mukca_effect_direction(direction, joints, e, &task->state);
    for (int j = 0; j < joints && ops->direction; j++) d->q[j] += e->coefficient[0] * direction[j];
    if (ops->basis) add_basis(d, ops->info.site, e, (const double(*)[3])basis);
    if (slopes && ops->by_angle) add_slopes(slopes, ops, joints, &in, (const double(*)[3])basis);
}

/* Load-independent effects.  Returns whether there are others. */
static bool apply_unloaded(mukca_displacement *displacement, mukca_effect_slopes *slopes,
                           const mukca_effect_task *task)
{
    bool loaded = false;
    memset(displacement, 0, sizeof *displacement);
    if (slopes) memset(slopes, 0, sizeof *slopes);
    for (int j = 0; j < task->chain->n_joints && slopes; j++) slopes->angle[j][1] = 1;
    for (const mukca_effect *e = task->effects; e < task->effects + task->n_effects; e++)
        if (mukca_effect_table[e->kind]->needs & MUKCA_NEEDS_MASSES)
            loaded = true;
        else
            add_effect(displacement, slopes, task, e);
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
    return fmax(fmax(mukca_largest_difference(a->base, b->base, 3),
                     mukca_largest_difference(a->q, b->q, joints)),
                mukca_largest_difference(a->rotation[0], b->rotation[0], 3 * joints));
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
                add_effect(displacement, NULL, &loaded, &task->effects[i]);
    } while (++rounds < MOST_ROUNDS &&
             difference(displacement, &before, task->chain->n_joints) > settled);
}

void mukca_effects_displacement(mukca_displacement *displacement, const mukca_effect *effects,
                                int n, const mukca_chain *chain, const mukca_geometry *geometry,
                                const mukca_joint_state *state)
{
    const mukca_effect_task task = {effects, n, chain, geometry, *state};
    mukca_effects_apply(displacement, NULL, &task);
}
