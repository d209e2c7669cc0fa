/* Tested effects, detection limits, and effects that are not testable. */
#include "diagnose/cause.h"

#include <math.h>
#include <stdlib.h>

#include "base/order.h"

/* Log evidence grows as amplitude^2 information / 2 and must exceed the prior odds, Occam's factor
 * and the threshold: some 12 in all. */
#define LEAST_EVIDENCE 12.0
/* Larger limits count as not testable: errors of this size are evident without a diagnosis.  rad,
 * m. */
#define MOST_ANGLE 10e-3
#define MOST_LENGTH 20e-3

/* Index of an effect at a joint, n_tested: it is not listed. */
static int find(const mukca_diagnosis *d, int kind, int joint)
{
    int t = 0;
    while (t < d->n_tested && ((int)d->tested[t].effect != kind || d->tested[t].joint != joint))
        t++;
    return t;
}

/* Append an effect at a joint, not yet scored, if there is room. */
static void add(mukca_diagnosis *d, int kind, int joint, double score, const char *why)
{
    if (d->n_tested == MUKCA_MAX_TESTED) return;
    d->tested[d->n_tested++] = (mukca_tested){.effect = (mukca_effect_kind)kind,
                                              .joint = joint,
                                              .log_bayes_factor = score,
                                              .log_odds = score,
                                              .limit = NAN,
                                              .why = why};
}

MUKCA_FALLING(by_odds, mukca_tested, log_odds)

/* Add the effects without a candidate, as a whole or at a joint. */
static void add_missing(mukca_diagnosis *d, const mukca_candidates *all)
{
    const mukca_effect_survey *survey = &all->survey;
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) {
        const bool turning = mukca_effect_table[kind]->site == MUKCA_SITE_ROTATION ||
                             mukca_effect_has(kind, MUKCA_TRAIT_PERIODIC);
        const char *why = all->enabled[kind] ? NULL
                          : all->disabled && all->disabled[kind]
                              ? "excluded on request"
                              : mukca_effect_missing((mukca_effect_kind)kind, survey);
        if (why) add(d, kind, -1, NAN, why);
        for (int j = 0; !why && mukca_effect_has_joint(kind) && j < survey->n_joints; j++)
            if ((survey->joint[j].turns || !turning) && find(d, kind, j) == d->n_tested)
                add(d, kind, j, NAN, mukca_effect_untested((mukca_effect_kind)kind, survey, j));
    }
}

void mukca_untested_list(mukca_diagnosis *d, const mukca_scan *scan)
{
    double most[MUKCA_MAX_TESTED] = {0}; /* information of the best member */
    d->n_tested = 0;
    for (int i = 0; i < scan->all->count; i++) { /* members of an effect at a joint together */
        const mukca_candidate *h = &scan->all->list[i];
        const int class = mukca_candidate_class(h);
        const double log_bayes = scan->value[i], odds = log_bayes + h->log_prior;
        if (class >= MUKCA_EFFECT_COUNT || !(log_bayes > -HUGE_VAL)) continue;
        const int t = find(d, class, h->joint);
        if (t == d->n_tested) add(d, class, h->joint, -HUGE_VAL, NULL);
        if (t == d->n_tested) continue; /* no room */
        mukca_tested *entry = &d->tested[t];
        if (log_bayes > entry->log_bayes_factor)
            entry->log_bayes_factor = log_bayes, most[t] = scan->information[i];
        const double hi = fmax(entry->log_odds, odds), lo = fmin(entry->log_odds, odds);
        entry->log_odds = lo > -HUGE_VAL ? hi + log1p(exp(lo - hi)) : hi;
    }
    for (int t = 0; t < d->n_tested; t++) {
        mukca_tested *entry = &d->tested[t];
        const int class = (int)entry->effect;
        entry->limit = sqrt(2 * LEAST_EVIDENCE / fmax(most[t], 1e-12));
        const bool length = mukca_effect_table[class]->site == MUKCA_SITE_TIP ||
                            mukca_effect_has(class, MUKCA_TRAIT_RECORDING_FAULT);
        entry->testable = entry->limit < (length ? MOST_LENGTH : MOST_ANGLE);
        entry->why = entry->testable ? NULL : mukca_effect_faint(entry->effect, entry->joint);
    }
    qsort(d->tested, (size_t)d->n_tested, sizeof *d->tested, by_odds);
    add_missing(d, scan->all);
}

void mukca_untested_all(mukca_diagnosis *d, const char *why)
{
    d->n_tested = 0;
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) add(d, kind, -1, NAN, why);
}
