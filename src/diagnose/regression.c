/* Regression of the diagnosis: fits. */
#include "diagnose/regression.h"

#include <math.h>
#include <string.h>

#include "math/stats.h"

/* Range of the search, m: from below any encoder to far above any arm. */
#define LEAST_NOISE 1e-6
#define MOST_NOISE 5e-2

/* Log evidence behind the best family from which one is negligible (3 million to 1). */
#define NEGLIGIBLE 15.0

mukca_status mukca_regression_create(mukca_regression *m, const mukca_chain *chain,
                                     const mukca_dataset *data,
                                     const mukca_recording_options *options, mukca_error *error)
{
    memset(m, 0, sizeof *m);
    if (mukca_recording_create(&m->recording, &m->pool, chain, data, options) &&
        mukca_unknowns_create(&m->unknowns, &m->pool, &m->recording) &&
        mukca_linearisation_create(&m->linear, &m->pool, &m->recording, &m->unknowns) &&
        mukca_evidence_create(&m->evidence, &m->pool, &m->linear, &m->unknowns)) {
        m->recording.workers = mukca_workers_start(options->threads);
        return MUKCA_OK;
    }
    mukca_regression_free(m);
    return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", data->n_rows);
}

void mukca_regression_free(mukca_regression *m)
{
    mukca_workers_stop(m->recording.workers);
    mukca_pool_free(&m->pool);
    memset(m, 0, sizeof *m);
}

void mukca_regression_linearise(mukca_regression *m)
{
    mukca_linearisation_update(&m->linear, &m->unknowns);
}

mukca_normal_equations *mukca_regression_collect(mukca_regression *m, int index)
{
    return mukca_evidence_collect(&m->evidence, index, &m->unknowns);
}

/* Evidence under one model of the unknowns, with their priors and noise. */
static double evidence_of(mukca_regression *m, const mukca_normal_equations *normal, int model,
                          double *mean)
{
    mukca_unknowns_prior(m->evidence.posterior.prior, &m->unknowns, model);
    return mukca_evidence_evaluate(&m->evidence, normal, m->unknowns.sigma, mean);
}

double mukca_regression_factor(mukca_regression *m)
{
    return evidence_of(m, mukca_regression_collect(m, m->unknowns.family), -1, NULL);
}

bool mukca_regression_solve(mukca_regression *m, const mukca_normal_equations *normal, int model)
{
    return evidence_of(m, normal, model, m->evidence.mean) > -HUGE_VAL;
}

/* Posterior mean of the present columns with the priors of the last evaluation. */
static void find_mean(mukca_regression *m)
{
    mukca_evidence_evaluate(&m->evidence, mukca_regression_collect(m, m->unknowns.family),
                            m->unknowns.sigma, m->evidence.mean);
}

bool mukca_regression_average(mukca_regression *m, const mukca_normal_equations *normal)
{
    const mukca_unknowns *u = &m->unknowns;
    mukca_evidence *evidence = &m->evidence;
    const int n = mukca_unknowns_column(u, u->n_causes);
    if (!u->n_models || !u->n_causes) return mukca_regression_solve(m, normal, -1);
    memset(evidence->average, 0, sizeof *evidence->average * (size_t)n);
    for (int k = 0; k < u->n_models; k++) {
        if (!mukca_regression_solve(m, normal, k)) return false;
        for (int i = 0; i < n; i++) evidence->average[i] += u->model_weight[k] * evidence->mean[i];
    }
    memcpy(evidence->mean, evidence->average, sizeof *evidence->mean * (size_t)n);
    return true;
}

double mukca_regression_standard_error(mukca_regression *m, int column, const double *direction,
                                       int terms)
{
    double *x = m->evidence.posterior.work; /* scratch */
    memset(x, 0, sizeof *x * (size_t)m->linear.n_columns);
    memcpy(x + column, direction, sizeof *x * (size_t)terms);
    return sqrt(mukca_posterior_variance(x, &m->evidence.posterior));
}

/* Log prior of a size that is expected: as of so many numbers of it. */
static double log_expected(double weight, double size, double expected)
{
    return -weight * (log(size / expected) + 0.5 * pow(expected / size, 2));
}

typedef struct {
    mukca_evidence *evidence;
    const mukca_normal_equations *normal;
} along_noise;

static double minus_evidence(void *context, double log_sigma)
{
    const along_noise *a = context;
    const double sigma = exp(log_sigma);
    return -mukca_evidence_evaluate(a->evidence, a->normal, sigma, NULL) -
           log_expected(a->evidence->expected, sigma, MUKCA_PRIOR_NOISE);
}

double mukca_noise_choose(mukca_evidence *evidence, const mukca_normal_equations *normal,
                          double guess, double *value)
{
    const double tolerance = 0.01; /* a hundredth of sigma: far below its uncertainty */
    along_noise context = {evidence, normal};
    double best, lo = log(guess / 2), hi = log(2 * guess);
    double x = mukca_stats_minimize(&best, minus_evidence, &context, lo, hi, tolerance);
    if (x < lo + 5 * tolerance || x > hi - 5 * tolerance) /* a bad guess: search the whole range */
        x = mukca_stats_minimize(&best, minus_evidence, &context, log(LEAST_NOISE), log(MOST_NOISE),
                                 tolerance);
    if (value) *value = -best;
    return exp(x);
}

static void choose_cause(mukca_accepted *cause, mukca_regression *m,
                         const mukca_normal_equations *normal)
{
    const mukca_mixture prior = mukca_candidate_mixture(&cause->candidate);
    double best = -HUGE_VAL, chosen = 0;
    for (int i = 0; i < prior.n_sizes; i++) {
        cause->scale = prior.size[i];
        const double value = prior.log_weight[i] + evidence_of(m, normal, -1, NULL);
        if (value > best) best = value, chosen = prior.size[i];
    }
    cause->scale = chosen;
}

void mukca_scales_choose(mukca_regression *m, const mukca_normal_equations *normal)
{
    /* Errors of published arms: links 0.5 to 4 mm, axes 1 to 10 mrad; half of that, those
     * calibrated by their makers. */
    static const double lengths[] = {0.25e-3, 0.5e-3, 1e-3, 2e-3, 4e-3};
    static const double angles[] = {0.5e-3, 1e-3, 2.5e-3, 5e-3, 10e-3};
    enum { N = 5 };
    mukca_unknowns *u = &m->unknowns;
    const double part = m->evidence.expected / 2;
    double best = -HUGE_VAL;
    int chosen = 0;
    for (int i = 0; i <= N * N; i++) {
        const int k = i < N * N ? i : chosen;
        u->prior.length = lengths[k / N], u->prior.angle = angles[k % N];
        mukca_unknowns_set_geometry_prior(u, &m->recording);
        if (i == N * N) break;
        const double value = evidence_of(m, normal, -1, NULL) +
                             log_expected(part, u->prior.length, mukca_prior_expected.length) +
                             log_expected(part, u->prior.angle, mukca_prior_expected.angle);
        if (value > best) best = value, chosen = k;
    }
    for (int c = 0; c < u->n_causes; c++)
        if (!u->cause[c].known && !u->cause[c].sized) choose_cause(&u->cause[c], m, normal);
    mukca_unknowns_prior(m->evidence.posterior.prior, u, -1);
}

/* Choose noise and its family by evidence, and the prior scales with them; returns the normal
 * equations of the best family.  The present one is tried first. */
static mukca_normal_equations *choose_noise(mukca_regression *m, mukca_fit_freedom freedom)
{
    mukca_unknowns *u = &m->unknowns;
    mukca_evidence *evidence = &m->evidence;
    const int present = u->weight ? 0 : u->family;
    mukca_normal_equations *chosen = NULL;
    const int noises = u->weight ? 1 : evidence->n_noises;
    double best = -HUGE_VAL, value[MUKCA_NOISES] = {0};
    if (!u->weight && m->recording.repeats) {
        find_mean(m);
        mukca_evidence_measure_noise(evidence);
    }
    bool all = noises == evidence->n_noises; /* robust weights imply independent samples */
    for (int k = 0; k < noises; k++) {
        const int i = (present + k) % noises;
        const bool open = freedom == MUKCA_FIT_ALL || !(mukca_evidence_family(evidence, i).rho > 0);
        /* since the last comparison, it may have gained as much as the best one has changed */
        const double behind = evidence->normal[i].behind - fabs(best - evidence->best);
        if (!open || (chosen && !(behind <= NEGLIGIBLE))) {
            all = false;
            continue;
        }
        mukca_normal_equations *normal = mukca_regression_collect(m, i);
        const double sigma = mukca_noise_choose(evidence, normal, u->sigma, &value[i]);
        if (chosen && !(value[i] > best)) continue;
        best = value[i], u->sigma = sigma, u->family = i;
        chosen = normal;
    }
    for (int i = 0; i < noises && all; i++) evidence->normal[i].behind = best - value[i];
    if (all) evidence->best = best;
    mukca_scales_choose(m, chosen);
    u->sigma = mukca_noise_choose(evidence, chosen, u->sigma, NULL);
    return chosen;
}

/* Weight the orientations for equal noise of orientations and positions, within two decades. */
static void weigh_rotations(mukca_regression *m)
{
    double length = 0, angle = 0;
    const double *y = mukca_evidence_residuals(&m->evidence);
    for (int i = 0; i < m->recording.n_samples * 6; i++)
        *(i % 6 < 3 ? &length : &angle) += y[i] * y[i];
    if (angle > 0 && length > 0)
        m->unknowns.rotation_weight =
            fmin(fmax(m->unknowns.rotation_weight * sqrt(length / angle), 1e-2), 1e2);
}

double mukca_regression_score(mukca_regression *m)
{
    double score = mukca_regression_factor(m);
    for (int c = 0; c < m->unknowns.n_causes; c++) {
        const mukca_accepted *cause = &m->unknowns.cause[c];
        if (cause->known) continue;
        const mukca_mixture prior = mukca_candidate_mixture(&cause->candidate);
        int at = 0;
        while (at + 1 < prior.n_sizes && prior.size[at] != cause->scale) at++;
        score += cause->candidate.log_prior + prior.log_weight[at];
    }
    return score;
}

/* Set the unknowns to the posterior mean; returns the largest change of the geometry. */
static double advance(mukca_regression *m)
{
    mukca_unknowns *u = &m->unknowns;
    double change = 0;
    for (int k = 0; k < u->n_geometry; k++)
        change = fmax(change, fabs(m->evidence.mean[k] - u->theta[k]));
    mukca_unknowns_set(u, m->evidence.mean);
    mukca_unknowns_fold_frames(u);
    return change;
}

/* Posterior mean of the present linearisation; false: the normal equations are singular. */
static bool solve(mukca_regression *m, mukca_fit_freedom freedom)
{
    mukca_unknowns_prior(m->evidence.posterior.prior, &m->unknowns, -1);
    return mukca_regression_average(m, freedom == MUKCA_FIT_UNKNOWNS
                                           ? mukca_regression_collect(m, m->unknowns.family)
                                           : choose_noise(m, freedom));
}

void mukca_regression_step(mukca_regression *m, mukca_fit_freedom freedom)
{
    if (solve(m, freedom)) advance(m);
    mukca_regression_linearise(m);
}

void mukca_regression_fit(mukca_regression *m, int iterations, mukca_fit_freedom freedom)
{
    mukca_unknowns *u = &m->unknowns;
    mukca_unknowns_set_geometry_prior(u, &m->recording);
    for (int i = 0; i < m->evidence.n_noises; i++)
        m->evidence.normal[i].behind = 0; /* compare again */
    for (int it = 0; it < iterations; it++) {
        mukca_regression_linearise(m);
        /* The weight of the orientations changes in each iteration, and the noise with it. */
        const bool weigh = m->recording.dim == 6 && !u->n_causes;
        const bool choose = it == 0 || it == 2 || weigh;
        if (!solve(m, choose ? freedom : MUKCA_FIT_UNKNOWNS)) break;
        if (weigh && it + 1 < iterations) weigh_rotations(m);
        if (advance(m) < 1e-7 && it >= 1) { /* 0.1 um and 0.1 urad: far below any noise */
            if (weigh) break;
            mukca_unknowns_set_geometry(u, m->recording.chain);
            return;
        }
    }
    mukca_regression_linearise(m);
}

void mukca_regression_fit_tails(mukca_regression *m, double *weight, int steps)
{
    enum { WEIGHINGS = 3 };      /* in a step; they go on in the next one */
    const double settled = 1e-3; /* a tenth of what 5000 rows know of the noise */
    mukca_unknowns *u = &m->unknowns;
    mukca_evidence *evidence = &m->evidence;
    for (int row = 0; row < m->recording.data->n_rows && !u->tails; row++) weight[row] = 1;
    u->tails = weight;
    mukca_unknowns_set_geometry_prior(u, &m->recording);
    for (int step = 0; step < steps; step++) {
        mukca_regression_linearise(m);
        mukca_regression_choose_share(m);
        for (int k = 0; k < WEIGHINGS; k++) {
            const double before = u->sigma;
            u->sigma =
                mukca_noise_choose(evidence, mukca_regression_collect(m, u->family), before, NULL);
            find_mean(m);
            mukca_evidence_weigh_tails(weight, evidence, u->sigma);
            if (fabs(u->sigma / before - 1) < settled) break;
        }
        mukca_scales_choose(m, mukca_regression_collect(m, u->family));
        find_mean(m);
        advance(m);
    }
    mukca_regression_linearise(m);
    find_mean(m);
}

void mukca_regression_choose_share(mukca_regression *m)
{
    mukca_unknowns *u = &m->unknowns;
    mukca_evidence *evidence = &m->evidence;
    double best, value;
    mukca_regression_solve(m, mukca_regression_collect(m, u->family), -1);
    const int proposed = mukca_evidence_measure_noise(evidence),
              step = proposed > evidence->angular[0] ? 1 : -1;
    if (proposed == evidence->angular[0]) return;
    mukca_noise_choose(evidence, mukca_regression_collect(m, u->family), u->sigma, &best);
    while (evidence->angular[0] != proposed) {
        mukca_evidence_set_share(evidence, evidence->angular[0] + step);
        mukca_noise_choose(evidence, mukca_regression_collect(m, u->family), u->sigma, &value);
        if (!(value > best)) {
            mukca_evidence_set_share(evidence, evidence->angular[0] - step);
            return;
        }
        best = value;
    }
}

double mukca_regression_choose_tails(mukca_regression *m, double *weight)
{
    enum { ROUNDS = 6 }; /* the weights have settled to a hundredth */
    mukca_unknowns *u = &m->unknowns;
    mukca_evidence *evidence = &m->evidence;
    double gaussian, value = 0, gain = 0, sigma;
    u->tails = NULL;
    mukca_evidence_renew(evidence);
    const double prior = mukca_regression_score(m) - mukca_regression_factor(m);
    u->sigma = sigma =
        mukca_noise_choose(evidence, mukca_regression_collect(m, u->family), u->sigma, &gaussian);
    for (int row = 0; row < m->recording.data->n_rows; row++) weight[row] = 1;
    for (int round = 0; round < ROUNDS; round++) {
        mukca_evidence_evaluate(evidence, mukca_regression_collect(m, u->family), sigma,
                                evidence->mean);
        gain = mukca_evidence_weigh_tails(weight, evidence, sigma);
        u->tails = weight;
        sigma = mukca_noise_choose(evidence, mukca_regression_collect(m, u->family), sigma, &value);
    }
    if (value + gain > gaussian) {
        u->sigma = sigma;
        return prior + value + gain;
    }
    u->tails = NULL;
    mukca_evidence_renew(evidence);
    return prior + gaussian;
}

void mukca_regression_freeze(mukca_regression *m)
{
    mukca_unknowns_fold_frames(&m->unknowns);
    mukca_regression_linearise(m);
}

/* Select the columns of the present causes without a new linearisation.  False: they are neither
 * none nor those of the linearisation. */
static bool select_columns(mukca_linearisation *linear, const mukca_unknowns *u)
{
    for (int c = 0; c < u->n_causes; c++)
        if (u->n_causes != linear->n_causes ||
            !mukca_candidate_same(&linear->cause[c], &u->cause[c].candidate))
            return false;
    linear->n_columns = u->n_causes ? linear->y : u->n_geometry;
    return true;
}

void mukca_regression_return(mukca_regression *m)
{
    if (!select_columns(&m->linear, &m->unknowns)) mukca_regression_freeze(m);
}
