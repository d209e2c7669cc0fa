/* The side of the load: efforts of the opposite sign, gravity in another direction. */
#include "diagnose/diagnose.h"

#include <math.h>
#include <string.h>

#include "diagnose/candidates.h"
#include "diagnose/cause.h"
#include "diagnose/regression.h"
#include "diagnose/scan.h"
#include "infer/sets.h"

/* Log odds by which another direction must lead: one arm in a hundred hangs from a wall or a
 * ceiling without --gravity, five directions are tested, and 20 to 1 as for every cause. */
#define LEAD (4.6 + 1.6 + 3.0)
/* Directions closer to the model's gravity than this cosine (some 30 degrees) are the same. */
static const double same_direction = 0.85;

static bool is_elastic(const mukca_cause *cause)
{
    return mukca_effect_has((int)cause->effect.kind, MUKCA_TRAIT_ELASTIC);
}

/* Do elastic causes alone explain everything? */
static bool all_elastic(const mukca_diagnosis *d)
{
    bool elastic = d->verdict != MUKCA_VERDICT_UNKNOWN && d->n_causes > 0 && !d->unexplained;
    for (int i = 0; i < d->n_causes; i++) elastic &= is_elastic(&d->causes[i]);
    return elastic;
}

/* Set gravity to the k-th of +x, -x, +y ... of the base frame; false: this direction is not worth
 * testing.  The direction opposite to the model's is tested if the verdict is unknown. */
static bool is_worth_testing(double gravity[3], int k, const mukca_diagnosis *given)
{
    const double size = mukca_norm3(gravity);
    const double cosine = (k % 2 ? -1 : 1) * gravity[k / 2] / size;
    if (!(cosine < same_direction)) return false;
    if (cosine < -same_direction && given->verdict != MUKCA_VERDICT_UNKNOWN) return false;
    memset(gravity, 0, 3 * sizeof *gravity);
    gravity[k / 2] = k % 2 ? -size : size;
    return true;
}

/* Log posterior of the best set of elastic effects, beside the faults of the recording, under its
 * gravity. */
static mukca_status weigh_springs(double *value, mukca_regression *m, const mukca_unknowns *faults,
                                  const unsigned char *disabled, mukca_error *error)
{
    enum { BUDGET = 8 }; /* sets of a few springs: a comparison, not a diagnosis */
    mukca_pool pool = {0};
    mukca_candidates springs;
    mukca_question question;
    mukca_scan scan;
    mukca_sets sets;
    mukca_recording_load(&m->recording);
    mukca_status status =
        mukca_candidates_list_springs(&springs, &pool, &m->recording, disabled, error);
    int *index = MUKCA_TAKE(&pool, int, springs.count + 1);
    mukca_unknowns_assign(&m->unknowns, faults);
    mukca_regression_freeze(m); /* another load has other columns */
    const double prior = mukca_regression_score(m) - mukca_regression_factor(m);
    for (int i = 0; i < springs.count && index; i++) index[i] = i;
    if (status == MUKCA_OK &&
        !(mukca_scan_create(&scan, &pool, m, &springs) &&
          mukca_scan_aim(&scan, m->unknowns.family) &&
          mukca_scan_question(&question, &scan, &pool, index, springs.count) &&
          mukca_sets_create(&sets, &pool, &question)))
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for the springs");
    if (status == MUKCA_OK) {
        mukca_sets_explore(&sets, BUDGET, false);
        *value = scan.evidence + sets.set[sets.best].value + prior;
    }
    mukca_pool_free(&pool);
    return status;
}

mukca_status mukca_efforts_weigh(double lead[1], mukca_regression *m, const unsigned char *disabled,
                                 mukca_error *error)
{
    bool *turned = &m->recording.options.turned_efforts;
    mukca_unknowns start;
    double written = 0, reversed = 0;
    if (!mukca_unknowns_clone(&start, &m->pool, &m->unknowns))
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the springs");
    mukca_status status = weigh_springs(&written, m, &start, disabled, error);
    *turned = true;
    if (status == MUKCA_OK) status = weigh_springs(&reversed, m, &start, disabled, error);
    *turned = false;
    *lead = reversed - written;
    mukca_recording_load(&m->recording);
    mukca_unknowns_assign(&m->unknowns, &start);
    return status;
}

mukca_status mukca_mounting_compare(mukca_diagnosis *d, mukca_regression *m,
                                    const unsigned char *disabled, mukca_error *error)
{
    const mukca_chain *chain = m->recording.chain;
    if (d->verdict == MUKCA_VERDICT_NONE || !chain->n_masses || all_elastic(d))
        return MUKCA_OK; /* nothing to explain, no torques, or no doubt */
    mukca_chain *turned = MUKCA_TAKE(&m->pool, mukca_chain, 1);
    mukca_unknowns faults;
    for (int c = m->unknowns.n_causes - 1; c >= 0; c--)
        if (!mukca_candidate_is_fault(&m->unknowns.cause[c].candidate))
            mukca_unknowns_drop(&m->unknowns, c);
    if (!mukca_unknowns_clone(&faults, &m->pool, &m->unknowns) || m->pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the springs");
    double best = -HUGE_VAL, upright, value;
    mukca_status status = weigh_springs(&upright, m, &faults, disabled, error);
    m->recording.chain = turned;
    for (int k = 0; k < 6 && status == MUKCA_OK; k++) {
        *turned = *chain;
        if (!is_worth_testing(turned->gravity, k, d)) continue;
        status = weigh_springs(&value, m, &faults, disabled, error);
        if (status != MUKCA_OK || !(value > fmax(best, fmax(upright, d->score) + LEAD))) continue;
        best = value;
        memcpy(d->gravity, turned->gravity, sizeof d->gravity);
    }
    if (isfinite(best)) {
        /* elastic effects under another load imitate it: with even odds, there is no finding */
        for (int i = 0; i < d->n_findings && d->n_maybe < MUKCA_MOST_FINDINGS; i++) {
            d->maybe[d->n_maybe] = d->findings[i];
            d->maybe[d->n_maybe++].group.probability *= 0.5;
        }
        d->n_findings = 0;
        for (int i = 0; i < d->n_causes; i++)
            d->causes[i].or_unknown = true, d->causes[i].probability *= 0.5;
        if (d->verdict == MUKCA_VERDICT_NAMED) d->verdict = MUKCA_VERDICT_TIED;
    }
    return status;
}
