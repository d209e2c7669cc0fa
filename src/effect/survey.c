/* What to try with a recording, and why not. */
#include "effect/survey.h"

#include "effect/catalogue.h"

bool mukca_effect_candidate(mukca_effect *effect, mukca_effect_kind kind, int joint,
                            const mukca_effect_survey *survey, int i)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[kind];
    *effect = (mukca_effect){.kind = kind, .joint = joint, .placement = -1};
    if (!ops->candidate || !ops->candidate(effect, survey, i)) return false;
    effect->terms = mukca_effect_terms(effect);
    return true;
}

const char *mukca_effect_missing(mukca_effect_kind kind, const mukca_effect_survey *survey)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[kind];
    const int needs = ops->info.needs;
    if (needs & MUKCA_NEEDS_MASSES) return "no masses: give --inertials FILE";
    if ((needs & MUKCA_NEEDS_PLACEMENTS) && survey->sockets)
        return "one placement only: record a second one";
    if (needs & MUKCA_NEEDS_PLACEMENTS) return "a log of poses has no placements";
    if ((needs & MUKCA_NEEDS_SOCKETS) && !survey->sockets) return "a log of poses has no sockets";
    if (ops->missing) return ops->missing;
    return needs & MUKCA_NEEDS_ORDER ? "no moves between rows" : "no joint moved enough";
}

const char *mukca_effect_untested(mukca_effect_kind kind, const mukca_effect_survey *survey,
                                  int joint)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[kind];
    if (ops->untested) return ops->untested(survey, joint);
    return survey->joint[joint].range < MUKCA_LEAST_RANGE
               ? "it did not move: record poses that turn it"
               : "these rows hold nothing that tells of it";
}

const char *mukca_effect_faint(mukca_effect_kind kind, int joint)
{
    const mukca_effect_ops *ops = mukca_effect_catalogue[kind];
    const char *why = ops->faint ? ops->faint(joint) : NULL;
    if (why) return why;
    if (joint < 0) return "too faint for these rows: record more";
    return "hardly moves the ball in these poses: turn it further, or mount the ball off its axis";
}
