/* Tested effects, detection limits, and effects that are not testable. */
#include "diagnose/untested.h"

#include <math.h>

/* Log evidence grows as amplitude^2 information / 2 and must exceed the prior odds, Occam's factor
 * and the threshold: some 12 in all. */
#define LEAST_EVIDENCE 12.0
/* Larger limits count as not testable: errors of this size are evident without a diagnosis.  rad,
 * m. */
#define MOST_ANGLE 10e-3
#define MOST_LENGTH 20e-3

static bool listed(const mukca_tested_list *tested, int kind, int joint)
{
    for (int t = 0; t < tested->count; t++)
        if ((int)tested->list[t].effect == kind && tested->list[t].joint == joint) return true;
    return false;
}

static void add(mukca_tested_list *tested, int kind, int joint, const char *why)
{
    if (tested->count == MUKCA_MAX_TESTED) return;
    tested->list[tested->count++] = (mukca_tested){.effect = (mukca_effect_kind)kind,
                                                   .joint = joint,
                                                   .log_bayes_factor = NAN,
                                                   .log_odds = NAN,
                                                   .limit = NAN,
                                                   .testable = false,
                                                   .why = why};
}

/* Add the effects without a candidate, as a whole or at a joint. */
static void add_missing(mukca_tested_list *tested, const mukca_candidates *all)
{
    const mukca_effect_survey *survey = &all->survey;
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) {
        const bool turning = mukca_effect_table[kind]->site == MUKCA_SITE_ROTATION ||
                             mukca_effect_has(kind, MUKCA_TRAIT_PERIODIC);
        const char *why = kind == MUKCA_EFFECT_GEAR_HARMONIC && !all->harmonics
                              ? "excluded on request"
                              : all->missing[kind];
        if (why) add(tested, kind, -1, why);
        for (int j = 0; !why && mukca_effect_has_joint(kind) && j < survey->n_joints; j++)
            if ((survey->joint[j].turns || !turning) && !listed(tested, kind, j))
                add(tested, kind, j, mukca_effect_untested((mukca_effect_kind)kind, survey, j));
    }
}

void mukca_untested_list(mukca_tested_list *tested, const mukca_competition *contest)
{
    tested->count = 0;
    for (int i = 0; i < contest->n_first && tested->count < MUKCA_MAX_TESTED; i++) {
        const mukca_contender *c = &contest->first[i];
        if (c->class >= MUKCA_EFFECT_COUNT || listed(tested, c->class, c->joint)) continue;
        const mukca_score *score = &contest->first_score[c->best];
        const double limit = sqrt(2 * LEAST_EVIDENCE / fmax(score->information, 1e-12));
        const bool length = mukca_effect_table[c->class]->site == MUKCA_SITE_TIP ||
                            mukca_effect_has(c->class, MUKCA_TRAIT_RECORDING_FAULT);
        const bool testable = limit < (length ? MOST_LENGTH : MOST_ANGLE);
        tested->list[tested->count++] = (mukca_tested){
            .effect = (mukca_effect_kind)c->class,
            .joint = c->joint,
            .log_bayes_factor = score->log_bayes,
            .log_odds = c->log_odds,
            .limit = limit,
            .testable = testable,
            .why = testable ? NULL : mukca_effect_faint((mukca_effect_kind)c->class, c->joint)};
    }
    add_missing(tested, contest->all);
}

void mukca_untested_all(mukca_tested_list *tested, const char *why)
{
    tested->count = 0;
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) add(tested, kind, -1, why);
}
