/* Displacement of the arm by one effect, and by all load-independent effects. */
#include <math.h>
#include <string.h>

#include "effect/catalogue.h"
#include "effect/equilibrium.h"
#include "math/sincos.h"

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
        add_terms(slopes->rotation[e->joint], 3, e, (const double(*)[3])slope);
    else
        add_terms(&slopes->angle[e->joint][1 + by], 1, e, (const double(*)[3])slope);
}

/* Displacement and derivatives of one effect; sine[2], cosine[2]: of a periodic effect's angles.
 */
static void add_unloaded(mukca_displacement *d, mukca_effect_slopes *slopes,
                         const mukca_effect_task *task, const mukca_effect *e, const double *sine,
                         const double *cosine)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[e->kind];
    const mukca_basis_input in = {.effect = e,
                                  .axis = effect_axis(e, task),
                                  .state = &task->state,
                                  .sine = sine,
                                  .cosine = cosine};
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

void mukca_effects_unloaded(mukca_displacement *displacement, mukca_effect_slopes *slopes,
                            joint_angles *bare, const mukca_effect_task *task)
{
    enum { TOGETHER = 4 }; /* periodic effects per call of mukca_sincos(): all lanes */
    const mukca_effect *waiting[TOGETHER];
    double angle[TOGETHER], sine[TOGETHER], cosine[TOGETHER];
    int n = 0;
    const int joints = task->chain->n_joints;
    memset(displacement->q, 0, (size_t)joints * sizeof *displacement->q);
    memset(displacement->rotation, 0, (size_t)joints * sizeof *displacement->rotation);
    for (int a = 0; a < 3; a++) displacement->base[a] = displacement->tip[a] = 0;
    displacement->any_rotation = false;
    bare->q = task->state.q;
    if (!mukca_sincos_near(bare->s, bare->c, bare->q, joints))
        bare->s[0] = bare->c[0] = (double)NAN;
    for (int j = 0; j < joints && slopes; j++) {
        const double own[3] = {0, 1, 0}, none[3] = {0};
        memcpy(slopes->angle[j], own, sizeof own);
        memcpy(slopes->rotation[j], none, sizeof none);
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
            angle[n++] = (e->variant.order ? e->variant.order : 1) * bare->q[e->joint];
        }
        if (n == 0 || (n < TOGETHER && i < task->n_effects)) continue;
        mukca_sincos(sine, cosine, angle, n);
        for (int k = 0; k < n; k++) {
            const int j = waiting[k]->joint;
            const double s[2] = {sine[k], bare->s[j]}, c[2] = {cosine[k], bare->c[j]};
            add_unloaded(displacement, slopes, task, waiting[k], s, c);
        }
        n = 0;
    }
}
