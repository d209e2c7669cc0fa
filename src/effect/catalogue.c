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

void mukca_effect_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                        const double axis[3], const mukca_joint_state *state)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[effect->kind];
    double angle[2], sine[4], cosine[4];
    const mukca_basis_input in = {
        .effect = effect, .axis = axis, .state = state, .sine = sine, .cosine = cosine};
    memset(basis, 0, MUKCA_MAX_TERMS * sizeof *basis);
    if (ops->info.traits & MUKCA_TRAIT_PERIODIC) {
        angle[1] = state->q[effect->joint];
        angle[0] = (effect->variant.order ? effect->variant.order : 1) * angle[1];
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

/* ---- candidates for a recording, and reasons why there are none ---- */

bool mukca_effect_candidate(mukca_effect *effect, mukca_effect_kind kind, int joint,
                            const mukca_effect_survey *survey, int i)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[kind];
    *effect = (mukca_effect){.kind = kind, .joint = joint, .placement = -1};
    if ((ops->info.traits & MUKCA_TRAIT_PERIODIC) && !survey->joint[joint].turns) return false;
    if (!ops->candidate || !ops->candidate(effect, survey, i)) return false;
    effect->terms = mukca_effect_terms(effect);
    return true;
}

const char *mukca_effect_missing(mukca_effect_kind kind, const mukca_effect_survey *survey)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[kind];
    const int needs = ops->info.needs;
    if ((needs & MUKCA_NEEDS_COMMANDS) && !survey->by_command)
        return "the angles are readings; for commanded ones give --angles command";
    if (needs & MUKCA_NEEDS_MASSES) return "no link masses; give --inertials FILE";
    if ((needs & MUKCA_NEEDS_PLACEMENTS) && survey->sockets)
        return "one placement only; record a second one";
    if (needs & MUKCA_NEEDS_PLACEMENTS) return "a pose log has no placements";
    if ((needs & MUKCA_NEEDS_SOCKETS) && !survey->sockets) return "a pose log has no sockets";
    if (ops->missing) return ops->missing;
    return needs & MUKCA_NEEDS_ORDER ? "no joint moved between samples" : "no joint moved enough";
}

const char *mukca_effect_untested(mukca_effect_kind kind, const mukca_effect_survey *survey,
                                  int joint)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[kind];
    const bool loads = ops->info.needs & MUKCA_NEEDS_MASSES;
    if (loads && survey->joint[joint].torque_most < MUKCA_LEAST_TORQUE)
        return "no gravity torque about this joint in these postures";
    if (ops->untested) return ops->untested;
    if (survey->joint[joint].range < MUKCA_LEAST_RANGE)
        return "this joint did not move; record postures with a wider range of this joint";
    return "these samples do not depend on it";
}

const char *mukca_effect_faint(mukca_effect_kind kind, int joint)
{
    const char *at_first = mukca_effect_catalogue[kind]->faint_at_first;
    if (joint == 0 && at_first) return at_first;
    if (joint < 0) return "too small to detect with these samples; record more";
    return "has almost no effect on the tip in these postures; use a wider range of this joint, or "
           "mount ball or target off its axis";
}
