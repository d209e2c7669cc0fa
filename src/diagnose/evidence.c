/* Evidence of the linearised model: normal equations, posterior, noise.
 *
 * The evidence of a linear model with Gaussian priors and noise is in closed form; sockets' means
 * are integrated out with a flat prior.  (C. M. Bishop, Pattern Recognition and Machine Learning,
 * 2006, section 3.5.)
 */
#include "diagnose/evidence.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "math/stats.h"

const double mukca_evidence_rho[MUKCA_RHOS] = {0.0, 0.25, 0.5};

/* Noise that is looked for at most, m: from below any encoder to far above any arm. */
#define LEAST_NOISE 1e-6
#define MOST_NOISE 5e-2

bool mukca_evidence_create(mukca_evidence *evidence, mukca_pool *pool,
                           const mukca_recording *recording, const mukca_unknowns *unknowns)
{
    const int capacity = mukca_unknowns_capacity(unknowns), size = capacity + 1;
    const int pairs = recording->data->n_distances + 1;
    for (int i = 0; i < MUKCA_RHOS; i++)
        evidence->normal[i] = (mukca_normal_equations){
            .rho = mukca_evidence_rho[i],
            .distance_sigma = recording->options.distance_sigma,
            .gram = MUKCA_TAKE(pool, double, size *size),
            .distance = MUKCA_TAKE(pool, double, pairs *size),
            .variance = MUKCA_TAKE(pool, double, pairs),
            .white = MUKCA_TAKE(pool, double,
                                (size_t)(recording->data->n_rows * recording->dim) * (size_t)size)};
    evidence->work = MUKCA_TAKE(pool, double, size);
    evidence->factor = MUKCA_TAKE(pool, double, size *size);
    evidence->marginal = MUKCA_TAKE(pool, double, 4 * size * size);
    evidence->order = MUKCA_TAKE(pool, int, size);
    evidence->mark = MUKCA_TAKE(pool, unsigned char, size);
    evidence->prior = MUKCA_TAKE(pool, double, capacity);
    evidence->mean = MUKCA_TAKE(pool, double, capacity);
    return !pool->failed;
}

int mukca_evidence_index(double rho)
{
    int index = 0;
    for (int i = 0; i < MUKCA_RHOS; i++)
        if (mukca_evidence_rho[i] == rho) index = i;
    return index;
}

/* What the normal equations are collected from. */
typedef struct {
    mukca_normal_equations *normal;
    const mukca_recording *recording;
    const mukca_linearisation *linear;
    const double *weight; /* [n_rows] of the noise, NULL: none */
    double *mean;         /* [size] scratch */
    double root;          /* sqrt(1 - rho^2) */
} collection;

static double weight_of(const collection *c, int sample)
{
    return c->weight ? c->weight[c->recording->order[sample]] : 1;
}

/* Whiten the columns of a group; returns o'o, o being the whitened ones. */
static double whiten(const collection *from, const mukca_group *group)
{
    const double rho = from->normal->rho;
    const size_t step = (size_t)from->recording->dim * (size_t)(from->normal->n + 1),
                 at = (size_t)group->start * step;
    const double *X = from->linear->columns + at;
    double *W = from->normal->white + at, sum = 0;
    for (int i = 0; i < group->count; i++, X += step, W += step) {
        const double w = weight_of(from, group->start + i);
        double own, before;
        mukca_evidence_whitening(&own, &before, i, from->root, rho);
        sum += (own - before) * w * ((own - before) * w);
        if (i && rho > 0) {
            const double *last = X - step;
            for (size_t k = 0; k < step; k++) W[k] = w * (own * X[k] - before * last[k]);
        } else {
            for (size_t k = 0; k < step; k++) W[k] = w * X[k];
        }
    }
    return sum;
}

/* Take the socket's mean out of a group's whitened columns and into the distance rows. */
static void centre(const collection *from, int g, double weights)
{
    const mukca_group *group = &from->recording->groups[g];
    mukca_normal_equations *normal = from->normal;
    const int d = from->recording->dim, size = normal->n + 1;
    const size_t step = (size_t)d * (size_t)size;
    const double later = (1 - normal->rho) / from->root; /* whitened 1 behind a group's first */
    for (int c = 0; c < 3; c++) {
        double *W = normal->white + (size_t)(group->start * d + c) * (size_t)size;
        double *mean = from->mean;
        memset(mean, 0, sizeof *mean * (size_t)size);
        for (int i = 0; i < group->count; i++) {
            const double one = weight_of(from, group->start + i) * (i ? later : 1) / weights;
            const double *row = W + (size_t)i * step;
            for (int k = 0; k < size; k++) mean[k] += one * row[k];
        }
        for (int i = 0; i < group->count; i++) {
            const double one = weight_of(from, group->start + i) * (i ? later : 1);
            double *row = W + (size_t)i * step;
            for (int k = 0; k < size; k++) row[k] -= one * mean[k];
        }
        for (int p = 0; p < normal->n_pairs; p++) {
            const mukca_socket_pair *pair = &from->recording->pairs[p];
            if (pair->a != g && pair->b != g) continue;
            const double along = from->linear->direction[p][c],
                         sign = pair->a == g ? along : -along;
            for (int k = 0; k < size; k++) normal->distance[p * size + k] += sign * mean[k];
            if (c == 0) normal->variance[p] += 1 / weights;
        }
    }
}

mukca_normal_equations *mukca_evidence_collect(mukca_evidence *evidence, int index,
                                               const mukca_recording *recording,
                                               const mukca_unknowns *unknowns,
                                               const mukca_linearisation *linear)
{
    mukca_normal_equations *normal = &evidence->normal[index];
    const int d = recording->dim, size = linear->n_columns + 1;
    const double rho = normal->rho;
    if (!unknowns->weight && normal->version == linear->version) return normal;
    normal->version = unknowns->weight ? 0 : linear->version;
    const collection from = {.normal = normal,
                             .recording = recording,
                             .linear = linear,
                             .weight = unknowns->weight,
                             .mean = evidence->work,
                             .root = sqrt(1 - rho * rho)};
    normal->n = linear->n_columns;
    normal->n_pairs = recording->n_pairs;
    normal->log_det = 0;
    normal->dof = 0;
    memcpy(normal->distance, linear->pair_columns,
           sizeof *normal->distance * (size_t)(normal->n_pairs * size));
    for (int p = 0; p < normal->n_pairs; p++) {
        normal->variance[p] = 0;
        normal->distance[p * size + size - 1] = recording->pairs[p].distance;
    }
    for (int g = 0; g < recording->n_groups; g++) {
        const mukca_group *group = &recording->groups[g];
        if (!group->count) continue;
        const double weights = whiten(&from, group);
        normal->log_det -= 0.5 * d * (group->count - 1) * log(1 - rho * rho);
        normal->dof += d * group->count;
        if (group->socket < 0) continue;
        normal->dof -= 3;
        normal->log_det -= 0.5 * 3 * log(weights);
        centre(&from, g, weights);
    }
    memset(normal->gram, 0, sizeof *normal->gram * (size_t)(size * size));
    mukca_dense_syrk(normal->gram, size, normal->white, recording->n_samples * d, size);
    return normal;
}

double mukca_evidence_evaluate(mukca_evidence *evidence, const mukca_normal_equations *normal,
                               double sigma, double *mean)
{
    const int n = normal->n, size = n + 1;
    const double precision = 1 / (sigma * sigma), *prior = evidence->prior;
    const double known = normal->distance_sigma * normal->distance_sigma;
    double *L = evidence->factor, *z = evidence->work;
    double quadratic = precision * normal->gram[size * size - 1], log_variance = 0,
           log_diagonal = 0;

    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) L[i * n + j] = precision * normal->gram[i * size + j];
        z[i] = precision * normal->gram[n * size + i];
    }
    for (int p = 0; p < normal->n_pairs; p++) {
        const double *row = normal->distance + p * size;
        const double variance = known + sigma * sigma * normal->variance[p], inverse = 1 / variance;
        quadratic += inverse * row[n] * row[n];
        log_variance += log(variance);
        for (int i = 0; i < n; i++) {
            z[i] += inverse * row[i] * row[n];
            for (int j = 0; j <= i; j++) L[i * n + j] += inverse * row[i] * row[j];
        }
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) L[i * n + j] *= prior[i] * prior[j];
        L[i * n + i] += 1;
        z[i] *= prior[i];
    }
    if (mukca_dense_cholesky(L, n)) return -HUGE_VAL;
    mukca_dense_forward(z, 1, L, n);
    for (int i = 0; i < n; i++) {
        quadratic -= z[i] * z[i];
        log_diagonal += log(L[i * n + i]);
    }
    evidence->quadratic = quadratic;
    if (mean) {
        memcpy(mean, z, sizeof *mean * (size_t)n);
        mukca_dense_backward(mean, 1, L, n);
        for (int i = 0; i < n; i++) mean[i] *= prior[i];
    }
    return -0.5 * quadratic - log_diagonal - normal->dof * log(sigma) - 0.5 * log_variance +
           normal->log_det;
}

double mukca_evidence_standard_error(mukca_evidence *evidence, int n, int column,
                                     const double *direction, int terms)
{
    double *x = evidence->work, variance = 0;
    memset(x, 0, sizeof *x * (size_t)n);
    for (int t = 0; t < terms; t++) x[column + t] = direction[t] * evidence->prior[column + t];
    mukca_dense_forward(x, 1, evidence->factor, n);
    for (int i = 0; i < n; i++) variance += x[i] * x[i];
    return sqrt(variance);
}

typedef struct {
    mukca_evidence *evidence;
    const mukca_normal_equations *normal;
} noise_context;

static double minus_evidence(void *context, double log_sigma)
{
    const noise_context *c = context;
    return -mukca_evidence_evaluate(c->evidence, c->normal, exp(log_sigma), NULL);
}

double mukca_evidence_noise(mukca_evidence *evidence, const mukca_normal_equations *normal,
                            double guess, double *value)
{
    const double tolerance = 0.01; /* a hundredth of sigma: far below what the data know of it */
    noise_context context = {evidence, normal};
    double best, lo = log(guess / 2), hi = log(2 * guess);
    double x = mukca_stats_minimize(&best, minus_evidence, &context, lo, hi, tolerance);
    if (x < lo + 5 * tolerance || x > hi - 5 * tolerance) /* the guess was none: look everywhere */
        x = mukca_stats_minimize(&best, minus_evidence, &context, log(LEAST_NOISE), log(MOST_NOISE),
                                 tolerance);
    if (value) *value = -best;
    return exp(x);
}
