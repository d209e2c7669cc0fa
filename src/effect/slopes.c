/* Derivatives of what effects do, by the joints' angles and by gravity's load. */
#include "effect/slopes.h"

#include "effect/catalogue.h"

static const double *axis_of(const mukca_effect *effect, const mukca_chain *chain)
{
    return effect->joint < 0 ? NULL : chain->element[chain->joint_element[effect->joint]].axis;
}

void mukca_effects_slopes_by_angle(mukca_effect_slopes *slopes, const mukca_effect *effects, int n,
                                   const mukca_chain *chain, const mukca_joint_state *state)
{
    for (const mukca_effect *e = effects; e < effects + n; e++) {
        const mukca_effect_ops *ops = mukca_effect_catalogue[e->kind];
        double basis[MUKCA_MAX_TERMS][3], slope[MUKCA_MAX_TERMS][3] = {{0}};
        const mukca_basis_input in = {.effect = e, .axis = axis_of(e, chain), .state = state};
        if (!ops->by_angle) continue;
        mukca_effect_basis(basis, e, in.axis, state);
        const int from = 1 + ops->by_angle(slope, &in, (const double(*)[3])basis);
        if (ops->info.site == MUKCA_SITE_ANGLES) {
            for (int j = 0; j < chain->n_joints; j++)
                slopes->angle[j][from] += e->coefficient[0] * slope[0][0];
            continue;
        }
        const bool turns = ops->info.site == MUKCA_SITE_ROTATION;
        double *into = turns ? slopes->rotation[e->joint] : &slopes->angle[e->joint][from];
        for (int t = 0; t < e->terms; t++)
            for (int i = 0; i < (turns ? 3 : 1); i++) into[i] += e->coefficient[t] * slope[t][i];
    }
}

void mukca_effects_slopes_by_load(mukca_effect_slopes *slopes, const mukca_effect *effects, int n,
                                  const mukca_joint_state *state)
{
    for (const mukca_effect *e = effects; e < effects + n; e++) {
        const mukca_effect_ops *ops = mukca_effect_catalogue[e->kind];
        if (!ops->by_load) continue;
        double *into = &slopes->base;
        if (ops->info.site == MUKCA_SITE_ANGLE) into = &slopes->spring[e->joint];
        if (ops->info.site == MUKCA_SITE_ROTATION) into = &slopes->bend[e->joint];
        *into += e->coefficient[0] * ops->by_load(e, state);
    }
}
