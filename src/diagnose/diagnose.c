/* The diagnosis: from a recording to a verdict. */
#include "diagnose/diagnose.h"

#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "diagnose/applied.h"
#include "diagnose/cause.h"
#include "diagnose/cross_validation.h"
#include "diagnose/identify.h"
#include "diagnose/logs.h"
#include "diagnose/streams.h"
#include "diagnose/test_data.h"
#include "diagnose/untested.h"
#include "fit/align.h"
#include "math/stats.h"

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

static const char does_not_fit[] =
    "the samples do not fit this arm: check the URDF, the tip, the columns and their order; a "
    "tracker's log needs --free-base and --free-tool";

/* Observations for the mean of a socket, and least number of others for the geometry. */
enum { PER_GROUP = 3, LEAST_NUMBERS = 12 };

/* Results of the steps. */
typedef struct {
    mukca_faults faults;
    mukca_findings findings;
    mukca_tested_list tested;
    mukca_validation validation;
    mukca_test_errors test;
    double sigma_m, rho, shared, sigma_rotation_rad; /* noise with all accepted candidates */
    double score;                                    /* of all accepted candidates */
    double structure_m;
    const char *why; /* reason why nothing can be tested, or NULL */
} steps;

/* Keep the geometry and the named causes for evaluation and output: an unknown function fits these
 * samples, but does not predict others. */
static void keep_named(mukca_regression *m, const mukca_findings *findings)
{
    bool keep[MUKCA_MAX_ACCEPTED] = {false};
    const int n = m->unknowns.n_causes;
    for (int i = 0; i < findings->n_causes; i++) {
        const int c =
            findings->causes[i].suspected ? -1 : mukca_cause_find(m, &findings->causes[i]);
        if (c >= 0) keep[c] = true;
    }
    for (int c = n - 1; c >= 0; c--)
        if (!keep[c] && !mukca_candidate_is_fault(&m->unknowns.cause[c].candidate))
            mukca_unknowns_drop(&m->unknowns, c);
    if (m->unknowns.n_causes < n) mukca_regression_fit(m, 4, MUKCA_FIT_NOISE);
}

/* Nothing can be tested; of the faults only duplicates are kept, as the others need a model that
 * fits. */
static void set_untestable(steps *s, mukca_regression *m, const char *why)
{
    int kept = 0;
    s->why = why;
    s->findings = (mukca_findings){.verdict = MUKCA_VERDICT_UNTESTABLE};
    mukca_untested_all(&s->tested, why);
    if (!m) return;
    for (int f = 0; f < s->faults.count; f++)
        if (s->faults.list[f].kind == MUKCA_FAULT_DUPLICATE)
            s->faults.list[kept++] = s->faults.list[f];
    s->faults.count = kept;
    m->unknowns.n_causes = 0;
    mukca_regression_fit(m, 4, MUKCA_FIT_ALL);
    s->sigma_m = m->unknowns.sigma;
}

/* Identify the causes, and reach the verdict. */
static mukca_status identify(steps *s, mukca_regression *m, const mukca_diagnose_options *options,
                             mukca_error *error)
{
    mukca_identification *id = MUKCA_TAKE(&m->pool, mukca_identification, 1);
    if (!id) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the candidates");
    *id = (mukca_identification){.m = m, .faults = &s->faults, .options = options};
    const mukca_status status = mukca_identify_run(id, error);
    s->score = mukca_regression_score(m);
    s->sigma_m = m->unknowns.sigma;
    s->rho = m->evidence.normal[m->unknowns.family].whitening.family.rho;
    s->shared = m->evidence.normal[m->unknowns.family].whitening.family.shared;
    s->sigma_rotation_rad = s->sigma_m / m->unknowns.rotation_weight;
    if (status == MUKCA_OK && s->sigma_m < MUKCA_MOST_SIGMA) {
        mukca_verdict_reach(&s->findings, &s->faults, id);
        mukca_untested_list(&s->tested, id);
        const bool none = s->findings.verdict == MUKCA_VERDICT_UNKNOWN;
        if (s->findings.unexplained || none) s->structure_m = mukca_cross_validation_structure(m);
        keep_named(m, &s->findings);
    } else if (status == MUKCA_OK) {
        set_untestable(s, m, does_not_fit);
    }
    mukca_identify_free(id);
    return status;
}

/* Held-out errors. */
static mukca_status validate(steps *s, mukca_pool *pool, mukca_regression *m,
                             const mukca_diagnose_options *options, mukca_error *error)
{
    mukca_status status =
        mukca_cross_validation_run(&s->validation, pool, m, &s->findings, options, error);
    /* unknown functions can absorb any error of the samples, but do not predict others */
    if (!s->why && s->validation.explained_m > MUKCA_MEAN_NORM3 * MUKCA_MOST_SIGMA) {
        set_untestable(s, m, does_not_fit);
        return validate(s, pool, m, options, error);
    }
    if (status == MUKCA_OK && options->test)
        status = mukca_test_data_measure(&s->test, pool, m, &s->validation.geometry, options->test,
                                         error);
    return status;
}

/* Leave uncertain causes that increase the error on the test data out of what is applied. */
static void drop_contradicted(steps *s, mukca_regression *m)
{
    mukca_unknowns *u = &m->unknowns;
    if (s->findings.verdict != MUKCA_VERDICT_TIED || !(s->test.explained_m > s->test.geometry_m))
        return;
    for (int c = u->n_causes - 1; c >= 0; c--)
        if (mukca_candidate_moves_arm(&u->cause[c].candidate)) mukca_unknowns_drop(u, c);
    s->test.after_m = s->test.of_geometry_m;
}

/* Combine the results of all steps for the report. */
static void assemble(mukca_diagnosis *d, const steps *s, const mukca_recording *recording)
{
    const mukca_validation *v = &s->validation;
    d->verdict = s->findings.verdict;
    d->why = s->why;
    d->unexplained = s->findings.unexplained;
    d->structure = s->findings.structure;
    d->n_where = s->findings.n_where;
    d->n_faults = s->faults.count;
    d->n_tested = s->tested.count;
    memcpy(d->where, s->findings.where, sizeof d->where);
    d->n_sets = s->findings.n_sets;
    memcpy(d->sets, s->findings.sets, sizeof d->sets);
    memcpy(d->faults, s->faults.list, sizeof d->faults);
    memcpy(d->tested, s->tested.list, sizeof d->tested);
    for (int c = 0; c < s->findings.n_causes; c++) {
        mukca_cause *cause = s->findings.causes[c].suspected ? &d->suspected[d->n_suspected++]
                                                             : &d->causes[d->n_causes++];
        *cause = s->findings.causes[c];
        cause->held_out = v->cause[c];
        cause->rung_m = v->rung_m[c];
    }
    memcpy(d->axis_rms_m, v->axis_rms_m, sizeof d->axis_rms_m);
    d->nominal_m = v->nominal_m;
    d->geometry_m = v->geometry_m;
    d->faults_excused_m = v->faults_excused_m;
    d->explained_m = v->explained_m;
    d->structure_m = s->structure_m;
    d->sigma_m = s->sigma_m;
    d->rho = s->rho;
    d->shared = s->shared;
    d->sigma_rotation_rad = s->sigma_rotation_rad;
    d->noise_floor_m = v->placement_m ? MUKCA_MEAN_NORM3 * d->sigma_m : (double)NAN;
    d->surprise = v->surprise;
    d->surprise_sigmas = v->surprise_sigmas;
    d->held_out = v->shrink;
    d->noise_shrink_percent = v->noise_shrink_percent;
    d->folds = v->folds;
    d->placement_mae_m = v->placement_m;
    d->test_nominal_m = s->test.nominal_m;
    d->test_geometry_m = s->test.geometry_m;
    d->test_explained_m = s->test.explained_m;
    d->test_placement_mae_m = s->test.placement_m;
    d->n_test_placements = s->test.n_placements;
    d->before_m = s->test.before_m ? s->test.before_m : v->before_m;
    d->after_m = s->test.before_m ? s->test.after_m : v->after_m;
    d->score = s->score;
    d->efforts_correlation = recording->efforts_correlation;
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
    const double started = mukca_clock_seconds();
    mukca_recording_options recording_options = {
        .mass_spread = options->mass_spread > 0 ? options->mass_spread : 0.1,
        .distance_sigma = MUKCA_DISTANCE_SIGMA,
        .free_base = options->free_base,
        .free_tool = options->free_tool};
    memset(diagnosis, 0, sizeof *diagnosis);
    mukca_regression *m = MUKCA_TAKE(&diagnosis->pool, mukca_regression, 1);
    mukca_chain *arm = MUKCA_TAKE(&diagnosis->pool, mukca_chain, 1);
    if (!m || !arm) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the arm");
    mukca_status status =
        mukca_chain_with_frames(arm, chain, false, options->free_tool && data->position, error);
    diagnosis->chain = chain = arm;
    if (status == MUKCA_OK)
        status = mukca_logs_compare(&diagnosis->logs, &recording_options, chain, data, error);
    if (status == MUKCA_OK)
        status = mukca_regression_create(m, chain, data, &recording_options, error);
    if (status != MUKCA_OK) {
        mukca_diagnosis_free(diagnosis);
        return status;
    }
    mukca_streams_compare(&diagnosis->streams, &m->recording);
    status = mukca_streams_fit(&diagnosis->streams, &recording_options, chain, data, error);
    steps *s = MUKCA_TAKE(&m->pool, steps, 1);
    if (!s || status != MUKCA_OK) goto out;
    s->structure_m = s->test.nominal_m = s->test.geometry_m = s->test.explained_m = NAN;
    mukca_cross_validation_clear(&s->validation);
    mukca_screening_run(&s->faults, m);
    const mukca_recording *recording = &m->recording;
    if (mukca_recording_distinct(recording) * recording->dim <
        PER_GROUP * recording->n_groups + LEAST_NUMBERS) {
        set_untestable(s, NULL, "too few different samples: record 20 or more for each socket");
    } else {
        mukca_regression_fit(m, 6, MUKCA_FIT_ALL);
        if (s->faults.misfit)
            set_untestable(s, m, does_not_fit);
        else
            status = identify(s, m, options, error);
        diagnosis->geometry = m->unknowns.geometry;
        diagnosis->tracker = m->unknowns.log.tracker[0];
        if (status == MUKCA_OK && !options->no_folds)
            status = validate(s, &diagnosis->pool, m, options, error);
        drop_contradicted(s, m);
        if (status == MUKCA_OK && options->applied) mukca_applied_fit(&diagnosis->applied, m);
    }
    assemble(diagnosis, s, recording);
    if (status == MUKCA_OK && options->go_on && diagnosis->verdict != MUKCA_VERDICT_UNTESTABLE)
        status = options->go_on(options->go_on_context, m, diagnosis, error);
out:
    if (status == MUKCA_OK && (m->pool.failed || diagnosis->pool.failed))
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", data->n_rows);
    mukca_regression_free(m);
    if (status != MUKCA_OK) mukca_diagnosis_free(diagnosis);
    diagnosis->elapsed_s = mukca_clock_seconds() - started;
    return status;
}
