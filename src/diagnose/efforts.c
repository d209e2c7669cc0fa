/* The sign of measured efforts: springs yield to their load. */
#include "diagnose/candidates.h"
#include "diagnose/diagnose.h"
#include "diagnose/regression.h"
#include "diagnose/scan.h"
#include "infer/sets.h"

/* Log posterior of the best set of elastic effects, beside the faults of the recording. */
static mukca_status weigh_springs(double *value, mukca_regression *m, const mukca_unknowns *faults,
                                  const unsigned char *disabled, mukca_error *error)
{
    enum { BUDGET = 8 }; /* sets of a few springs: a comparison, not a diagnosis */
    mukca_pool pool = {0};
    mukca_candidates springs;
    mukca_question question;
    mukca_scan scan;
    mukca_sets sets;
    unsigned char others[MUKCA_EFFECT_COUNT];
    mukca_status status = MUKCA_OK;
    for (int e = 0; e < MUKCA_EFFECT_COUNT; e++)
        others[e] = !mukca_effect_has(e, MUKCA_TRAIT_ELASTIC) || (disabled && disabled[e]);
    mukca_recording_load(&m->recording);
    mukca_candidates_start(&springs, &pool, &m->recording, others);
    mukca_candidates_fill(&springs, NULL);
    int *index = MUKCA_TAKE(&pool, int, springs.count + 1);
    mukca_unknowns_assign(&m->unknowns, faults);
    mukca_regression_freeze(m); /* another load has other columns */
    const double prior = mukca_regression_score(m) - mukca_regression_factor(m);
    for (int i = 0; i < springs.count && index; i++) index[i] = i;
    if (pool.failed || !(mukca_scan_create(&scan, &pool, m, &springs) &&
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
