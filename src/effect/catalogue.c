/* The catalogue of effects: table and queries. */
#include "effect/catalogue.h"

#include <string.h>

#include "math/sincos.h"

const mukca_effect_ops *const mukca_effect_catalogue[MUKCA_EFFECT_COUNT] = {
#define ROW(kind, name) &mukca_##name##_effect,
    MUKCA_EFFECT_LIST(ROW)
#undef ROW
};

const mukca_effect_info *const mukca_effect_table[MUKCA_EFFECT_COUNT] = {
#define ROW(kind, name) &mukca_##name##_effect.info,
    MUKCA_EFFECT_LIST(ROW)
#undef ROW
};

int mukca_effect_find(const char *name)
{
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++)
        if (!strcmp(mukca_effect_table[kind]->name, name)) return kind;
    return -1;
}

bool mukca_effect_has(int kind, int traits)
{
    return kind >= 0 && kind < MUKCA_EFFECT_COUNT &&
           (mukca_effect_table[kind]->traits & traits) != 0;
}

bool mukca_effect_has_joint(int kind)
{
    const mukca_effect_site site = mukca_effect_table[kind]->site;
    return site == MUKCA_SITE_ANGLE || site == MUKCA_SITE_ROTATION;
}

bool mukca_effect_is_smooth(const mukca_effect *effect)
{
    /* gravity torque has orders 1 and 2 in a joint's angle, up to 3 with a neighbour's */
    return mukca_effect_has((int)effect->kind, MUKCA_TRAIT_SMOOTH) && effect->variant.order <= 3;
}

bool mukca_effect_same(const mukca_effect *a, const mukca_effect *b)
{
    const mukca_effect_variant *x = &a->variant, *y = &b->variant;
    return a->kind == b->kind && a->joint == b->joint && a->placement == b->placement &&
           x->order == y->order && x->frame == y->frame && x->neighbour == y->neighbour &&
           x->torque_scale == y->torque_scale && x->time_constant == y->time_constant &&
           x->to_command == y->to_command;
}

int mukca_effect_terms(const mukca_effect *effect)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[effect->kind];
    if (!ops->variant_terms) return ops->info.terms;
    int terms = 0;
    while (ops->variant_terms(&effect->variant)[terms]) terms++;
    return terms;
}

void mukca_effect_wave(double angle[2], const mukca_effect *effect, const mukca_joint_state *state)
{
    const int order = effect->variant.order ? effect->variant.order : 1;
    angle[1] = state->q[effect->joint];
    angle[0] = order * angle[1];
}

void mukca_effect_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                        const double axis[3], const mukca_joint_state *state)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[effect->kind];
    double angle[2], sine[4], cosine[4];
    const mukca_basis_input in = {
        .effect = effect, .axis = axis, .state = state, .sine = sine, .cosine = cosine};
    memset(basis, 0, MUKCA_MAX_TERMS * sizeof *basis);
    if (ops->info.traits & MUKCA_TRAIT_PERIODIC) {
        mukca_effect_wave(angle, effect, state);
        mukca_sincos(sine, cosine, angle, 2);
    }
    if (ops->basis) ops->basis(basis, &in);
}

void mukca_effect_direction(double *direction, int n_joints, const mukca_effect *effect,
                            const mukca_joint_state *state)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[effect->kind];
    memset(direction, 0, (size_t)n_joints * sizeof *direction);
    if (ops->direction) ops->direction(direction, n_joints, effect, state);
}
