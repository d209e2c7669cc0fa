/* The diagnosis: from a recording to a verdict. */
#include "diagnose/diagnose.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "diagnose/cause.h"
#include "diagnose/findings.h"
#include "diagnose/held_out.h"
#include "diagnose/identify.h"
#include "diagnose/logs.h"
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

/* Log odds by which reversed efforts must lead: drivers of one arm in five report the torque of the
 * load, and 20 to 1 as for every cause. */
#define LEAD_OF_SIGN (1.6 + 3.0)

/* Why there are too few different samples, NULL: there are not.  In measured poses, an arm's
 * geometry has 4 numbers for each turning and 2 for each sliding joint, and 6 for base and tool
 * (Everett et al. 1987; 3 fewer without orientations).  As many again must be left: the noise is
 * estimated from these, and an effect is tested against it.  Of sockets: 3 for each mean, and 12.
 */
static const char *find_missing(mukca_diagnosis *d, const mukca_recording *r)
{
    const mukca_chain *chain = r->chain;
    int unknowns = r->dim == 6 ? 6 : 3, postures = 0;
    for (int i = 0; i < r->n_samples; i++) postures += r->samples.readings[i] > 0;
    for (int j = 0; j < chain->n_joints; j++)
        unknowns += chain->element[chain->joint_element[j]].type == MUKCA_PRISMATIC ? 2 : 4;
    const int needed = r->groups[0].socket < 0 ? 2 * unknowns : 3 * r->n_groups + 12;
    const int missing = (needed + r->dim - 1) / r->dim - postures;
    char *why = missing > 0 ? mukca_pool_take(&d->pool, 80, 1) : NULL;
    if (why) snprintf(why, 80, "too few different samples: record %d more", missing);
    return why;
}

/* Nothing can be tested; of the faults only duplicates are kept, as the others need a model that
 * fits. */
static void set_untestable(mukca_diagnosis *d, mukca_regression *m, const char *why)
{
    int kept = 0;
    d->why = why;
    d->verdict = MUKCA_VERDICT_UNTESTABLE;
    d->unexplained = false;
    d->structure = 0;
    d->n_findings = d->n_maybe = d->n_causes = d->n_suspected = d->n_where = d->n_sets = 0;
    mukca_untested_all(d, why);
    for (int f = 0; f < d->n_faults; f++)
        if (d->faults[f].kind == MUKCA_FAULT_DUPLICATE) d->faults[kept++] = d->faults[f];
    d->n_faults = kept;
    m->unknowns.n_causes = m->unknowns.n_models = 0;
    mukca_regression_fit(m, 4, MUKCA_FIT_ALL);
    d->sigma_m = m->unknowns.sigma;
}

/* Identify the causes, and reach the verdict. */
static mukca_status identify(mukca_diagnosis *d, mukca_regression *m,
                             const mukca_diagnose_options *options, mukca_error *error)
{
    mukca_search *search = MUKCA_TAKE(&m->pool, mukca_search, 1);
    if (!search) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the candidates");
    *search = (mukca_search){.m = m, .diagnosis = d, .options = options};
    mukca_status status = mukca_identify_run(search, error);
    if (status == MUKCA_OK) status = mukca_findings_reach(d, search, error);
    if (status == MUKCA_OK) mukca_identify_settle(search);
    d->score = mukca_regression_score(m);
    const mukca_noise_family *family = &m->evidence.normal[m->unknowns.family].whitening.family;
    d->sigma_m = m->unknowns.sigma;
    d->rho = family->rho;
    d->shared = family->shared;
    if (status == MUKCA_OK && d->sigma_m < MUKCA_MOST_SIGMA) {
        mukca_verdict_reach(d, search);
        if (d->unexplained || d->verdict == MUKCA_VERDICT_UNKNOWN)
            d->structure_m = mukca_held_out_structure(m);
        status = mukca_averaged_fit(m, search, error);
        if (search->pool.failed)
            status = mukca_fail(error, MUKCA_MEMORY, "out of memory for causes");
    } else if (status == MUKCA_OK) {
        set_untestable(d, m, does_not_fit);
    }
    mukca_identify_free(search);
    return status;
}

/* Held-out errors.  Uncertain causes that increase the error on the test data are left out of what
 * is applied. */
static mukca_status validate(mukca_diagnosis *d, mukca_regression *m,
                             const mukca_diagnose_options *options, mukca_error *error)
{
    mukca_unknowns *u = &m->unknowns;
    mukca_arm_state *geometry = MUKCA_TAKE(&m->pool, mukca_arm_state, 1);
    double *of_geometry =
        options->test ? MUKCA_TAKE(&d->pool, double, options->test->n_rows) : NULL;
    if (!geometry) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the arm");
    MUKCA_TRY(mukca_held_out_run(d, geometry, m, options, error));
    /* unknown functions can absorb any error of the samples, but do not predict others */
    if (!d->why && d->explained_m > MUKCA_MEAN_NORM3 * MUKCA_MOST_SIGMA) {
        set_untestable(d, m, does_not_fit);
        return validate(d, m, options, error);
    }
    if (d->placement_mae_m) d->noise_floor_m = MUKCA_MEAN_NORM3 * d->sigma_m;
    if (options->test)
        MUKCA_TRY(mukca_test_data_measure(d, of_geometry, m, geometry, options->test, error));
    if (d->verdict != MUKCA_VERDICT_TIED || !(d->test_explained_m > d->test_geometry_m))
        return MUKCA_OK;
    for (int c = u->n_causes - 1; c >= 0; c--)
        if (mukca_candidate_moves_arm(&u->cause[c].candidate)) mukca_unknowns_drop(u, c);
    d->after_m = of_geometry;
    return MUKCA_OK;
}

/* Set all errors to not measured. */
static void clear_errors(mukca_diagnosis *d)
{
    d->nominal_m = d->geometry_m = d->faults_excused_m = d->explained_m = d->noise_floor_m =
        d->structure_m = d->test_nominal_m = d->test_geometry_m = d->test_explained_m = NAN;
    d->held_out = MUKCA_SHRINK_NONE;
}

/* Without masses, measured efforts are the loads.  A spring yields to its load: if all causes with
 * the opposite sign are far more probable, the efforts are those of the load on the joint. */
static mukca_status choose_sign(mukca_regression *m, const mukca_diagnose_options *options,
                                mukca_error *error)
{
    const mukca_recording *r = &m->recording;
    double score[2], lead = 0;
    if (r->n_bodies || !r->data->effort || options->efforts) return MUKCA_OK;
    MUKCA_TRY(mukca_efforts_weigh(&lead, m, options->disabled, error));
    if (!(lead > LEAD_OF_SIGN)) return MUKCA_OK; /* usually */
    mukca_diagnosis *tried = MUKCA_TAKE(&m->pool, mukca_diagnosis, 1);
    if (!tried) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the efforts");
    mukca_diagnose_options o = *options;
    o.no_folds = true, o.applied = false, o.go_on = NULL;
    for (int i = 0; i < 2; i++) {
        o.efforts = i ? -1 : 1;
        MUKCA_TRY(mukca_diagnose(tried, r->chain, r->data, &o, error));
        score[i] = tried->score;
        mukca_diagnosis_free(tried);
    }
    m->recording.options.turned_efforts = score[1] > score[0] + LEAD_OF_SIGN;
    mukca_recording_load(&m->recording);
    return MUKCA_OK;
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
        .free_base = options->free_base,
        .free_tool = options->free_tool,
        .turned_efforts = options->efforts < 0,
        .threads = options->threads};
    memset(diagnosis, 0, sizeof *diagnosis);
    mukca_regression *m = MUKCA_TAKE(&diagnosis->pool, mukca_regression, 1);
    mukca_chain *arm = MUKCA_TAKE(&diagnosis->pool, mukca_chain, 1);
    if (!m || !arm) {
        mukca_diagnosis_free(diagnosis);
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the arm");
    }
    mukca_status status =
        mukca_chain_with_frames(arm, chain, false, options->free_tool && data->position, error);
    diagnosis->chain = chain = arm;
    if (status == MUKCA_OK)
        status = mukca_logs_compare(&diagnosis->logs, &recording_options, chain, data, error);
    if (status == MUKCA_OK)
        status = mukca_regression_create(m, chain, data, &recording_options, error);
    if (status != MUKCA_OK) goto out;
    mukca_streams_compare(&diagnosis->streams, &m->recording);
    status = mukca_streams_fit(&diagnosis->streams, &recording_options, chain, data, error);
    if (status != MUKCA_OK) goto out;
    clear_errors(diagnosis);
    const bool fits = mukca_screening_run(diagnosis, m);
    const mukca_recording *recording = &m->recording;
    const char *missing = find_missing(diagnosis, recording);
    mukca_regression_fit(m, 6, MUKCA_FIT_ALL);
    if (missing || !fits)
        set_untestable(diagnosis, m, missing ? missing : does_not_fit);
    else if ((status = choose_sign(m, options, error)) == MUKCA_OK)
        status = identify(diagnosis, m, options, error);
    diagnosis->geometry = m->unknowns.arm.geometry;
    diagnosis->tracker = m->unknowns.arm.log.tracker[0];
    if (status == MUKCA_OK && !options->no_folds) status = validate(diagnosis, m, options, error);
    if (status == MUKCA_OK && options->applied && !missing)
        mukca_applied_fit(&diagnosis->applied, m);
    diagnosis->applied_m = diagnosis->explained_m;
    diagnosis->test_applied_m = diagnosis->test_explained_m;
    diagnosis->efforts_correlation = recording->efforts_correlation;
    diagnosis->turned_efforts = recording->options.turned_efforts;
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
