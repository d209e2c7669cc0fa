/* What effects do to a configuration of the arm, at the equilibrium under its load. */
#include <math.h>
#include <string.h>

#include "mukca/effect.h"
#include "mukca/gravity.h"

void mukca_effect_apply(mukca_displacement *displacement, const mukca_effect *effect,
                        const mukca_chain *chain, const mukca_joint_state *state)
{
    const int j = effect->joint;
    double basis[MUKCA_MAX_TERMS][3], direction[MUKCA_MAX_JOINTS];
    double *into = displacement->tip;
    switch (mukca_effect_table[effect->kind]->site) {
        case MUKCA_SITE_ANGLES:
            mukca_effect_direction(direction, chain->n_joints, effect, state);
            for (int i = 0; i < chain->n_joints; i++)
                displacement->q[i] += effect->coefficient[0] * direction[i];
            return;
        case MUKCA_SITE_SOCKET:
        case MUKCA_SITE_DISTANCE:
            return;
        case MUKCA_SITE_ANGLE:
            into = &displacement->q[j];
            break;
        case MUKCA_SITE_ROTATION:
            into = displacement->rotation[j];
            displacement->any_rotation = true;
            break;
        case MUKCA_SITE_BASE:
            into = displacement->base;
            displacement->any_rotation = true;
            break;
        case MUKCA_SITE_TIP:
            break;
    }
    const double *axis = j >= 0 ? chain->element[chain->joint_element[j]].axis : NULL;
    const int width = mukca_effect_table[effect->kind]->site == MUKCA_SITE_ANGLE ? 1 : 3;
    mukca_effect_basis(basis, effect, axis, state);
    for (int t = 0; t < effect->terms; t++)
        for (int i = 0; i < width; i++) into[i] += effect->coefficient[t] * basis[t][i];
}

/* Whether two displacements' angles and rotations differ by less than `limit`. */
static bool is_close(const mukca_displacement *a, const mukca_displacement *b, int n_joints,
                     double limit)
{
    bool close = true;
    for (int j = 0; j < n_joints; j++) {
        close &= !(fabs(a->q[j] - b->q[j]) >= limit);
        for (int i = 0; i < 3; i++)
            close &= !(fabs(a->rotation[j][i] - b->rotation[j][i]) >= limit);
    }
    for (int i = 0; i < 3; i++) close &= !(fabs(a->base[i] - b->base[i]) >= limit);
    return close;
}

static bool is_loaded(const mukca_effect *effect)
{
    return (mukca_effect_table[effect->kind]->needs & MUKCA_NEEDS_MASSES) != 0;
}

void mukca_effects_displacement(mukca_displacement *displacement, const mukca_effect *effects,
                                int n, const mukca_chain *chain, const mukca_geometry *geometry,
                                const double *q, const mukca_joint_state *state)
{
    enum { ROUNDS = 8 };
    mukca_joint_state full = {.placement = -1};
    mukca_gravity_load load;
    bool loaded = false;
    if (state) full = *state;
    full.q = q;
    for (int i = 0; i < n && !full.torque; i++) loaded |= is_loaded(&effects[i]);
    if (loaded) {
        mukca_chain_moments(&load, chain, geometry, q, NULL, full.payload_kg);
        full.torque = load.torque;
        full.moment = (const double(*)[3])load.moment;
        full.base_moment = load.base;
    }
    mukca_displacement before = {0}, unloaded = {0}; /* what does not depend on the load */
    for (int i = 0; i < n; i++)
        if (!is_loaded(&effects[i])) mukca_effect_apply(&unloaded, &effects[i], chain, &full);
    for (int round = 0; round < ROUNDS; round++) {
        *displacement = unloaded;
        for (int i = 0; i < n; i++)
            if (is_loaded(&effects[i])) mukca_effect_apply(displacement, &effects[i], chain, &full);
        if (!loaded || is_close(displacement, &before, chain->n_joints, 1e-12)) return;
        /* Once more under the load of the arm where it has come to: the equilibrium. */
        before = *displacement;
        mukca_chain_moments_displaced(&load, chain, geometry, q, displacement, full.payload_kg);
    }
}
