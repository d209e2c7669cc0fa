/* Diagnosis of the gap that geometry leaves: the way from a recording to a verdict. */
#include "diagnose/diagnose.h"

#include <math.h>
#include <string.h>
#include <time.h>

#include "diagnose/applied.h"
#include "diagnose/competition.h"
#include "diagnose/confounding.h"
#include "diagnose/cross_validation.h"
#include "diagnose/screening.h"
#include "diagnose/untested.h"
#include "diagnose/verdict.h"

const char *const mukca_verdict_name[] = {
#define VERDICT_NAME(name, text) text,
    MUKCA_VERDICT_LIST(VERDICT_NAME)
#undef VERDICT_NAME
};

const char *const mukca_fault_name[] = {
#define FAULT_NAME(name, text) text,
    MUKCA_FAULT_LIST(FAULT_NAME)
#undef FAULT_NAME
};

/* Standard deviations by which left-out rows may miss more than they should.  Where the truth was
 * modelled it was never above 1.7 in some 700 simulated cases, heavy tails and correlated rows
 * included: rows of a socket share their geometry's error, which the priors overstate. */
#define SURPRISED 2.0

/* Noise per axis above which no arm is so bad but the rows belong to another one, m. */
#define MOST_SIGMA 10e-3

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* What is measured and handed on is the geometry with the causes that were told: an unknown
 * function fits these rows and says nothing of others. */
static void keep_told(mukca_diagnosis *d, mukca_regression *m)
{
    bool dropped = false;
    if (d->unexplained || d->verdict == MUKCA_VERDICT_UNKNOWN)
        d->structure_m = mukca_cross_validation_structure(m);
    for (int c = 0; c < m->unknowns.n_causes; c++) {
        const mukca_candidate *h = &m->unknowns.cause[c].candidate;
        const int class = mukca_candidate_class(h);
        const bool fault = mukca_candidate_is_fault(h);
        if (fault || (class != MUKCA_CLASS_UNKNOWN && d->verdict != MUKCA_VERDICT_UNKNOWN))
            continue;
        mukca_unknowns_drop(&m->unknowns, c--);
        dropped = true;
    }
    if (dropped) mukca_regression_fit(m, 4, MUKCA_FIT_NOISE);
}

void mukca_diagnosis_free(mukca_diagnosis *diagnosis)
{
    mukca_pool_free(&diagnosis->pool);
    memset(diagnosis, 0, sizeof *diagnosis);
}

mukca_status mukca_diagnose(mukca_diagnosis *diagnosis, const mukca_chain *chain,
                            const mukca_dataset *data, const mukca_diagnose_options *options,
                            mukca_error *error)
{
    const double started = now_s();
    mukca_regression m;
    mukca_candidates all;
    mukca_scan scan = {0};
    mukca_competition contest = {&m, &all, &scan, diagnosis, options, NULL, 0, NULL, 0, NULL};
    const mukca_recording_options model_options = {
        .mass_spread = options->mass_spread > 0 ? options->mass_spread : 0.1,
        .distance_sigma = 1e-4,
        .free_base = options->free_base,
        .free_tool = options->free_tool};
    memset(diagnosis, 0, sizeof *diagnosis);
    mukca_status status = mukca_regression_create(&m, chain, data, &model_options, error);
    if (status != MUKCA_OK) return status;

    mukca_screening_run(diagnosis, &m);
    mukca_cross_validation_clear(diagnosis);
    diagnosis->efforts_correlation = m.recording.efforts_correlation;
    if (mukca_untested_distinct(&m.recording) * m.recording.dim < 3 * m.recording.n_groups + 12) {
        mukca_untested_all(diagnosis, "too few different rows: record 20 or more for each socket");
        goto out;
    }
    mukca_regression_fit(&m, 6, MUKCA_FIT_ALL);
    status =
        mukca_candidates_list(&all, &m.pool, &m.recording, &m.unknowns, options->disabled, error);
    if (status != MUKCA_OK) goto out;
    status = mukca_scan_create(&scan, &all, &m, error);
    if (status != MUKCA_OK) goto out;
    const int most = all.count + chain->n_joints * MUKCA_RIPPLE_MOST;
    contest.table = MUKCA_TAKE(&m.pool, mukca_contender, most);
    contest.first = MUKCA_TAKE(&m.pool, mukca_contender, most);
    contest.first_score = MUKCA_TAKE(&m.pool, mukca_score, most);
    if (m.pool.failed) {
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for the competition of causes");
        goto out;
    }
    status = mukca_competition_run(&contest, error);
    if (status != MUKCA_OK) goto out;
    diagnosis->sigma_m = m.unknowns.sigma;
    diagnosis->rho = m.unknowns.rho;
    if (m.unknowns.sigma < MOST_SIGMA) {
        mukca_verdict_reach(diagnosis, &contest);
        if (options->confounding) mukca_confounding_measure(diagnosis, &contest);
        keep_told(diagnosis, &m);
    } else {
        mukca_untested_all(diagnosis,
                           "the rows do not fit this arm: check the URDF, the tip, the columns and "
                           "their order; a tracker's log needs --free-base and --free-tool");
        int told = 0; /* where a row belongs, an arm that does not fit cannot say */
        for (int f = 0; f < diagnosis->n_faults; f++)
            if (diagnosis->faults[f].kind == MUKCA_FAULT_DUPLICATE)
                diagnosis->faults[told++] = diagnosis->faults[f];
        diagnosis->n_faults = told;
        while (m.unknowns.n_causes) mukca_unknowns_drop(&m.unknowns, 0);
        mukca_regression_fit(&m, 4, MUKCA_FIT_ALL);
    }
    diagnosis->geometry = m.unknowns.geometry;
    diagnosis->tracker = m.unknowns.tracker;
    if (!options->no_folds) status = mukca_cross_validation_run(diagnosis, &m, options, error);
    if (diagnosis->surprise_sigmas > SURPRISED) {
        if (diagnosis->verdict == MUKCA_VERDICT_NONE)
            diagnosis->verdict = MUKCA_VERDICT_UNKNOWN;
        else
            diagnosis->unexplained = diagnosis->n_causes > 0;
    }
    if (status == MUKCA_OK && options->applied) mukca_applied_fit(diagnosis, &m);
    if (m.pool.failed || diagnosis->pool.failed)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", data->n_rows);
out:
    mukca_scan_free(&scan);
    mukca_regression_free(&m);
    if (status != MUKCA_OK) mukca_diagnosis_free(diagnosis);
    diagnosis->elapsed_s = now_s() - started;
    return status;
}
