/* What effects do to a configuration of the arm, each by itself. */
#include <string.h>

#include "effect/catalogue.h"
#include "effect/equilibrium.h"
#include "math/sincos.h"

const double *mukca_effect_axis(const mukca_effect *effect, const mukca_chain *chain)
{
    return effect->joint < 0 ? NULL : chain->element[chain->joint_element[effect->joint]].axis;
}

void mukca_effect_add(mukca_displacement *displacement, const mukca_effect *effect,
                      const double basis[][3])
{
    double *into = displacement->tip;
    switch (mukca_effect_table[effect->kind]->site) {
        case MUKCA_SITE_ANGLES:
        case MUKCA_SITE_SOCKET:
        case MUKCA_SITE_DISTANCE:
            return;
        case MUKCA_SITE_ANGLE:
            for (int t = 0; t < effect->terms; t++)
                displacement->q[effect->joint] += effect->coefficient[t] * basis[t][0];
            return;
        case MUKCA_SITE_ROTATION:
            into = displacement->rotation[effect->joint];
            displacement->any_rotation = true;
            break;
        case MUKCA_SITE_BASE:
            into = displacement->base;
            displacement->any_rotation = true;
            break;
        case MUKCA_SITE_TIP:
            break;
    }
    for (int t = 0; t < effect->terms; t++)
        for (int i = 0; i < 3; i++) into[i] += effect->coefficient[t] * basis[t][i];
}

static void add_direction(mukca_displacement *displacement, const mukca_effect *effect,
                          const mukca_chain *chain, const mukca_joint_state *state)
{
    double direction[MUKCA_MAX_JOINTS];
    mukca_effect_direction(direction, chain->n_joints, effect, state);
    for (int i = 0; i < chain->n_joints; i++)
        displacement->q[i] += effect->coefficient[0] * direction[i];
}

void mukca_effect_apply(mukca_displacement *displacement, const mukca_effect *effect,
                        const mukca_chain *chain, const mukca_joint_state *state)
{
    double basis[MUKCA_MAX_TERMS][3];
    if (mukca_effect_catalogue[effect->kind]->direction) {
        add_direction(displacement, effect, chain, state);
        return;
    }
    mukca_effect_basis(basis, effect, mukca_effect_axis(effect, chain), state);
    mukca_effect_add(displacement, effect, (const double(*)[3])basis);
}

/* Slopes of one effect, given its basis. */
static void add_slopes(mukca_effect_slopes *slopes, const mukca_effect_ops *ops, int n_joints,
                       const mukca_basis_input *in, const double basis[][3])
{
    const mukca_effect *e = in->effect;
    double slope[MUKCA_MAX_TERMS][3];
    memset(slope, 0, (size_t)e->terms * sizeof *slope);
    const int by = ops->by_angle(slope, in, basis);
    if (ops->direction) {
        for (int j = 0; j < n_joints; j++) slopes->angle[j][1] += e->coefficient[0] * slope[0][0];
    } else if (ops->info.site == MUKCA_SITE_ROTATION) {
        for (int t = 0; t < e->terms; t++)
            for (int i = 0; i < 3; i++)
                slopes->rotation[e->joint][i] += e->coefficient[t] * slope[t][i];
    } else {
        for (int t = 0; t < e->terms; t++)
            slopes->angle[e->joint][1 + by] += e->coefficient[t] * slope[t][0];
    }
}

/* Displacement and slopes of one effect; sine[2] and cosine[2] of a periodic one's angles. */
static void add_unloaded(mukca_displacement *d, mukca_effect_slopes *slopes,
                         const mukca_effect_task *task, const mukca_effect *e, const double *sine,
                         const double *cosine)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[e->kind];
    const mukca_basis_input in = {.effect = e,
                                  .axis = mukca_effect_axis(e, task->chain),
                                  .state = &task->state,
                                  .sine = sine,
                                  .cosine = cosine};
    double basis[MUKCA_MAX_TERMS][3];
    memset(basis, 0, (size_t)e->terms * sizeof *basis);
    if (ops->direction) add_direction(d, e, task->chain, &task->state);
    if (ops->basis) {
        ops->basis(basis, &in);
        mukca_effect_add(d, e, (const double(*)[3])basis);
    }
    if (slopes && ops->by_angle)
        add_slopes(slopes, ops, task->chain->n_joints, &in, (const double(*)[3])basis);
}

void mukca_effects_unloaded(mukca_displacement *displacement, mukca_effect_slopes *slopes,
                            const mukca_effect_task *task)
{
    enum { TOGETHER = 2 }; /* periodic effects, two angles each: all lanes of a call */
    const mukca_effect *waiting[TOGETHER];
    double angle[2 * TOGETHER] = {0}, sine[2 * TOGETHER], cosine[2 * TOGETHER];
    int n = 0;
    const size_t joints = (size_t)task->chain->n_joints;
    memset(displacement->q, 0, joints * sizeof *displacement->q);
    memset(displacement->rotation, 0, joints * sizeof *displacement->rotation);
    memset(displacement->base, 0, sizeof displacement->base);
    memset(displacement->tip, 0, sizeof displacement->tip);
    displacement->any_rotation = false;
    if (slopes) {
        memset(slopes->angle, 0, joints * sizeof *slopes->angle);
        memset(slopes->rotation, 0, joints * sizeof *slopes->rotation);
        for (size_t j = 0; j < joints; j++) slopes->angle[j][1] = 1;
    }
    for (int i = 0; i <= task->n_effects; i++) {
        const mukca_effect *e = task->effects + i;
        if (i < task->n_effects) {
            const mukca_effect_info *info = mukca_effect_table[e->kind];
            if (info->needs & MUKCA_NEEDS_MASSES) continue;
            if (!(info->traits & MUKCA_TRAIT_PERIODIC)) {
                add_unloaded(displacement, slopes, task, e, NULL, NULL);
                continue;
            }
            waiting[n] = e;
            mukca_effect_wave(angle + 2 * n++, e, &task->state);
        }
        if (n == 0 || (n < TOGETHER && i < task->n_effects)) continue;
        mukca_sincos(sine, cosine, angle, 2 * n);
        for (int k = 0; k < n; k++)
            add_unloaded(displacement, slopes, task, waiting[k], sine + 2 * k, cosine + 2 * k);
        n = 0;
    }
}
