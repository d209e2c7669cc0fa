/* Candidates for a recording, and reasons why there are none. */
#include "effect/survey.h"

#include "effect/catalogue.h"

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
