/* Evidence and posterior of the linearised model from its normal equations: in closed form for
 * Gaussian priors and noise (infer/posterior.h), with the means of the sockets integrated out. */
#include "diagnose/evidence.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "math/stats.h"

/* AR(1) coefficients up to the largest in recordings of swept postures. */
static const double correlations[] = {0, 0.25, 0.5, 0.75};
/* Variance that readings of a posture share, as a multiple of its estimate from the residuals: this
 * is too small by what the geometry absorbs, and too large while it is not fitted; and the
 * correlation of successive postures. */
static const double shared[][2] = {{0.4, 0},    {0.7, 0},    {1, 0},     {1.5, 0},
                                   {2.5, 0},    {0.7, 0.25}, {0.7, 0.5}, {0.7, 0.75},
                                   {1.5, 0.25}, {1.5, 0.5},  {1.5, 0.75}};
enum {
    INDEPENDENT_POSTURES = sizeof correlations / sizeof *correlations,
    SHARED_POSTURES = sizeof shared / sizeof *shared
};
_Static_assert(INDEPENDENT_POSTURES + SHARED_POSTURES == MUKCA_NOISES, "families of the noise");

/* Shares of the joint angles' noise. */
static const double shares[] = {0, 0.2, 0.4, 0.6, 0.8, 0.95};

/* Resolution of the positions, m: readings that agree exactly agree to this. */
#define RESOLUTION 1e-6

mukca_noise_family mukca_evidence_family(const mukca_evidence *evidence, int index)
{
    if (index < INDEPENDENT_POSTURES) return (mukca_noise_family){.rho = correlations[index]};
    const double *family = shared[index - INDEPENDENT_POSTURES], r = evidence->ratio * family[0];
    return (mukca_noise_family){.rho = family[1], .shared = r / (1 + r)};
}

bool mukca_evidence_create(mukca_evidence *evidence, mukca_pool *pool,
                           const mukca_linearisation *linear, const mukca_unknowns *unknowns)
{
    const mukca_recording *recording = linear->recording;
    const int capacity = mukca_unknowns_capacity(unknowns), size = capacity + 1;
    const int pairs = recording->data->n_distances + 1, rows = recording->data->n_rows;
    const size_t whole = (size_t)(rows * recording->dim + pairs) * (size_t)size;
    evidence->linear = linear;
    evidence->n_noises = INDEPENDENT_POSTURES;
    if (recording->repeats) evidence->n_noises = recording->targets ? 1 : MUKCA_NOISES;
    evidence->ratio = evidence->counted = 1;
    for (int i = 0; i < evidence->n_noises; i++) {
        mukca_normal_equations *normal = &evidence->normal[i];
        *normal = (mukca_normal_equations){.variance = MUKCA_TAKE(pool, double, pairs),
                                           .all_gram = MUKCA_TAKE(pool, double, size *size),
                                           .all_distance = MUKCA_TAKE(pool, double, pairs *size)};
        mukca_whitening_create(&normal->whitening, pool, rows, recording->data->n_sockets + 2,
                               recording->dim);
    }
    for (int k = 0; k < 1 + recording->repeats; k++)
        evidence->shape[k] = MUKCA_TAKE(pool, double, rows * recording->dim * recording->dim);
    evidence->white.x = MUKCA_TAKE(pool, double, whole);
    evidence->white.mean =
        MUKCA_TAKE(pool, double, (recording->data->n_sockets + 2) * recording->dim * size);
    mukca_posterior_take(&evidence->posterior, pool, capacity);
    evidence->mean = MUKCA_TAKE(pool, double, capacity);
    evidence->average = MUKCA_TAKE(pool, double, capacity);
    return !pool->failed;
}

void mukca_evidence_along(double *along, const double *mean, int n, int ld,
                          const mukca_linearisation *linear)
{
    const mukca_recording *r = linear->recording;
    for (int p = 0; p < r->n_pairs; p++)
        for (int c = 0; c < 3; c++) {
            const double *a = mean + (r->pairs[p].a * r->dim + c) * ld,
                         *b = mean + (r->pairs[p].b * r->dim + c) * ld, w = linear->direction[p][c];
            for (int k = 0; k < n; k++) along[p * ld + k] += w * (a[k] - b[k]);
        }
}

enum { TOGETHER = 32, PANEL = 16 }; /* columns of a block: whitened, multiplied */

/* Whiten some of the stored columns. */
static void whiten_columns(void *context, int block, int worker)
{
    const mukca_evidence *evidence = context;
    const mukca_linearisation *linear = evidence->linear;
    const int ld = linear->stride, from = block * TOGETHER, left = ld - from;
    (void)worker;
    mukca_whitening_apply(&(mukca_whitened){.n = left < TOGETHER ? left : TOGETHER,
                                            .ld = ld,
                                            .x = linear->columns + from,
                                            .white = evidence->white.x + from,
                                            .mean = evidence->white.mean + from},
                          &evidence->white.equations->whitening, &linear->recording->samples);
}

const double *mukca_evidence_whiten(mukca_evidence *evidence, const mukca_normal_equations *normal)
{
    if (evidence->white.equations == normal && evidence->white.version == normal->version &&
        normal->version)
        return evidence->white.x;
    evidence->white.equations = normal;
    evidence->white.version = normal->version;
    mukca_workers_run(evidence->linear->recording->workers,
                      (evidence->linear->stride + TOGETHER - 1) / TOGETHER, whiten_columns,
                      evidence);
    return evidence->white.x;
}

typedef struct {
    double *gram;
    const double *X;
    const mukca_recording *recording;
    int n;
    const int *fold;
    int number;
} multiplication;

/* The upper triangle's entries of some columns; the last ones, which have most, first. */
static void multiply_columns(void *context, int block, int worker)
{
    const multiplication *c = context;
    const mukca_recording *r = c->recording;
    const int n = c->n, d = r->dim, from = (n - 1) / PANEL * PANEL - block * PANEL,
              end = from + PANEL < n ? from + PANEL : n;
    (void)worker;
    for (int i = 0, count; i < r->n_samples; i += count ? count : 1) { /* runs of samples */
        for (count = 0;
             i + count < r->n_samples && (!c->fold || c->fold[r->order[i + count]] == c->number);)
            count++;
        const double *X = c->X + (size_t)(i * d) * (size_t)n;
        mukca_dense_xty_part(c->gram + from, n, (mukca_columns){X, end, n},
                             (mukca_columns){X + from, end - from, n}, count * d);
    }
}

void mukca_evidence_multiply(double *gram, const double *X, int n, const mukca_recording *r,
                             const int *fold, int number)
{
    multiplication c = {gram, X, r, n, fold, number};
    memset(gram, 0, sizeof *gram * (size_t)n * (size_t)n);
    mukca_workers_run(r->workers, (n + PANEL - 1) / PANEL, multiply_columns, &c);
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++) gram[i * n + j] = gram[j * n + i];
}

/* Products of all stored columns. */
static void multiply(mukca_evidence *evidence, mukca_normal_equations *normal)
{
    const mukca_linearisation *linear = evidence->linear;
    const mukca_recording *r = linear->recording;
    const int n = linear->stride;
    const double *white = mukca_evidence_whiten(evidence, normal);
    memcpy(normal->all_distance, linear->pair_columns, sizeof(double) * (size_t)(r->n_pairs * n));
    mukca_evidence_along(normal->all_distance, evidence->white.mean, n, n, linear);
    mukca_evidence_multiply(normal->all_gram, white, n, r, NULL, 0);
    normal->all_gram[n * n - 1] += /* the rounding of further readings of a posture */
        evidence->further * RESOLUTION * RESOLUTION / (1 - normal->whitening.family.shared);
}

/* Mean square of the levers of the joints over all samples. */
static double mean_lever(const mukca_linearisation *linear)
{
    const mukca_recording *r = linear->recording;
    double sum = 0;
    for (int i = 0; i < r->n_samples * r->chain->n_joints * r->dim; i++)
        sum += linear->lever[i] * linear->lever[i];
    return sum / (r->n_samples * r->dim);
}

/* Factor of the covariance of a sample, of unit mean variance: noise of the joint angles, equal in
 * all joints, moves the tip by their levers. */
static void factor_shape(double *L, const mukca_linearisation *linear, int sample, double angular,
                         double lever)
{
    const int n = linear->recording->chain->n_joints, d = linear->recording->dim;
    const double *J = linear->lever + sample * n * d;
    for (int a = 0; a < d; a++)
        for (int b = 0; b < d; b++) {
            double sum = 0;
            for (int j = 0; j < n; j++) sum += J[j * d + a] * J[j * d + b];
            L[a * d + b] = (a == b ? 1 - angular : 0) + angular * sum / lever;
        }
    mukca_dense_cholesky(L, d);
}

static mukca_noise_shape shape_of(mukca_evidence *evidence)
{
    const mukca_linearisation *linear = evidence->linear;
    const mukca_recording *r = linear->recording;
    if (!(evidence->angular[0] + evidence->angular[1])) return (mukca_noise_shape){NULL, NULL};
    const double lever = mean_lever(linear);
    for (int i = 0; i < r->n_samples && evidence->shaped != linear->version; i++)
        for (int k = 0; k < 1 + r->repeats; k++)
            factor_shape(evidence->shape[k] + i * r->dim * r->dim, linear, i,
                         shares[evidence->angular[k]], lever);
    evidence->shaped = linear->version;
    return (mukca_noise_shape){evidence->shape[0], evidence->shape[1]};
}

/* Factor the noise for the samples in use and their robust weights (NULL: none). */
static void lay_out(mukca_evidence *evidence, int index, const double *weight)
{
    const mukca_linearisation *linear = evidence->linear;
    const mukca_recording *r = linear->recording;
    mukca_normal_equations *normal = &evidence->normal[index];
    double *scratch = evidence->white.x;
    for (int i = 0; i < r->n_samples; i++) scratch[i] = weight ? weight[r->order[i]] : 1;
    evidence->counted = mukca_recording_count_targets(scratch, r, evidence->ratio);
    mukca_whitening_set(&normal->whitening, &r->samples, mukca_evidence_family(evidence, index),
                        shape_of(evidence), scratch);
    normal->whitening.dof = (int)(normal->whitening.dof * evidence->counted);
    normal->whitening.log_det *= evidence->counted;
    normal->n_pairs = r->n_pairs;
    for (int p = 0; p < r->n_pairs; p++) {
        const int side[] = {r->pairs[p].a, r->pairs[p].b};
        normal->variance[p] = 0;
        for (int k = 0; k < 2; k++) {
            double x[6] = {0};
            memcpy(x, linear->direction[p], sizeof linear->direction[p]);
            mukca_whitening_solve(x, &normal->whitening, side[k], r->dim);
            normal->variance[p] += mukca_dot3(x, linear->direction[p]);
        }
    }
}

/* Choose the share of the joint angles' noise by the likelihood of y[n_samples][dim], in which each
 * sample has so many degrees of freedom. */
static int angular_share(const double *y, const double *freedom, const mukca_linearisation *linear)
{
    const int d = linear->recording->dim;
    const double lever = mean_lever(linear);
    double best = -HUGE_VAL;
    int chosen = 0;
    for (int a = 0; a < (int)(sizeof shares / sizeof *shares) && lever > 0; a++) {
        double log_det = 0, square = 0, all = 0;
        for (int i = 0; i < linear->recording->n_samples; i++) {
            double L[36], x[6];
            if (!(freedom[i] > 0)) continue;
            factor_shape(L, linear, i, shares[a], lever);
            memcpy(x, y + i * d, sizeof *x * (size_t)d);
            mukca_dense_forward(x, 1, L, d);
            for (int c = 0; c < d; c++)
                square += x[c] * x[c], log_det += freedom[i] * log(L[c * d + c]);
            all += freedom[i] * d;
        }
        if (!(square > 0)) return 0; /* exact readings */
        const double value = -log_det - 0.5 * all * log(square);
        if (value > best) best = value, chosen = a;
    }
    return chosen;
}

double *mukca_evidence_residuals(mukca_evidence *evidence)
{
    const mukca_linearisation *linear = evidence->linear;
    const mukca_samples *s = &linear->recording->samples;
    double *y = evidence->white.x;
    evidence->white.equations = NULL;
    for (int i = 0; i < s->n_samples * s->dim; i++) {
        const double *x = linear->columns + (size_t)i * (size_t)linear->stride;
        y[i] = x[linear->y];
        for (int k = 0; k < linear->n_columns; k++) y[i] -= x[k] * evidence->mean[k];
    }
    return y;
}

int mukca_evidence_measure_noise(mukca_evidence *evidence)
{
    const mukca_samples *s = &evidence->linear->recording->samples;
    const int d = s->dim;
    double *y = mukca_evidence_residuals(evidence), *common = y + s->n_samples * d,
           *freedom = common + s->n_samples * d, within = 0, between = 0, reading = 0;
    int extra = 0, postures = 0;
    memset(freedom, 0, sizeof *freedom * (size_t)s->n_samples);
    for (int b = 0; b < s->n_blocks; b++)
        for (int c = 0; c < d; c++) {
            const int start = s->block[b].start, end = start + s->block[b].count;
            double sum = 0, square = 0;
            int count = 0;
            for (int i = start; i < end; i++) {
                double mean = 0;
                const int m = s->readings[i];
                for (int k = i; m && k >= 0; k = s->next[k]) mean += y[k * d + c] / m;
                for (int k = i; m && k >= 0; k = s->next[k])
                    y[k * d + c] -= mean, within += y[k * d + c] * y[k * d + c];
                common[i * d + c] = mean;
                if (!m) continue;
                sum += mean, square += mean * mean, reading += 1.0 / m, count++;
                extra += m - 1;
                freedom[i] = 1;
            }
            const bool free = s->block[b].free_mean && count;
            for (int i = start; i < end && free; i++) common[i * d + c] -= sum / count;
            between += square - (free ? sum * sum / count : 0);
            postures += count - free;
        }
    const int proposed = angular_share(common, freedom, evidence->linear);
    if (extra && postures >= 2) {
        const double variance = within / extra + RESOLUTION * RESOLUTION,
                     shared_part = between / postures - variance * reading / postures;
        evidence->further = extra;
        evidence->ratio = fmin(fmax(shared_part / variance, 0.1), 1e6);
        for (int i = 0; i < s->n_samples; i++) freedom[i] = 0;
        for (int i = 0; i < s->n_samples; i++)
            for (int k = i; k >= 0 && s->readings[i] > 1; k = s->next[k])
                freedom[k] = 1 - 1.0 / s->readings[i];
        evidence->angular[1] = angular_share(y, freedom, evidence->linear);
        mukca_evidence_set_share(evidence, evidence->angular[0]);
    }
    return proposed;
}

void mukca_evidence_set_share(mukca_evidence *evidence, int angular_share)
{
    evidence->angular[0] = angular_share;
    evidence->shaped = 0;
    mukca_evidence_renew(evidence);
}

void mukca_evidence_renew(mukca_evidence *evidence)
{
    for (int i = 0; i < evidence->n_noises; i++) evidence->normal[i].version = 0;
}

double *mukca_evidence_deviations(mukca_evidence *evidence, const double *weight)
{
    const mukca_recording *r = evidence->linear->recording;
    const mukca_samples *s = &r->samples;
    const int d = s->dim;
    double *y = mukca_evidence_residuals(evidence);
    for (int b = 0; b < s->n_blocks; b++) {
        const int start = s->block[b].start, end = start + s->block[b].count;
        double mean[6] = {0}, sum = 0;
        for (int i = start; i < end && s->block[b].free_mean; i++) {
            const double w = weight[r->order[i]] * weight[r->order[i]];
            sum += w;
            for (int c = 0; c < d; c++) mean[c] += w * (y[i * d + c] - mean[c]) / sum;
        }
        for (int i = start * d; i < end * d; i++) y[i] -= mean[i % d];
    }
    return y;
}

double mukca_evidence_weigh_tails(double *weight, mukca_evidence *evidence, double sigma)
{
    const mukca_recording *r = evidence->linear->recording;
    const int d = r->dim;
    const double *y = mukca_evidence_deviations(evidence, weight), nu = MUKCA_STUDENT_FREEDOM,
                 constant = lgamma(0.5 * (nu + d)) - lgamma(0.5 * nu) - 0.5 * d * log(0.5 * nu);
    double gain = 0;
    for (int i = 0; i < r->n_samples; i++) {
        double square = 0;
        for (int c = 0; c < d; c++) square += pow(y[i * d + c] / sigma, 2);
        const double w = (nu + d) / (nu + square);
        weight[r->order[i]] = sqrt(w);
        gain += constant - 0.5 * (nu + d) * log1p(square / nu) + 0.5 * w * square;
    }
    mukca_evidence_renew(evidence);
    return gain;
}

mukca_normal_equations *mukca_evidence_collect(mukca_evidence *evidence, int index,
                                               const mukca_unknowns *unknowns)
{
    const mukca_linearisation *linear = evidence->linear;
    mukca_normal_equations *normal = &evidence->normal[index];
    if (unknowns->weight || normal->version != linear->version) {
        lay_out(evidence, index, unknowns->weight ? unknowns->weight : unknowns->tails);
        evidence->white.equations = NULL;
        normal->version = unknowns->weight ? 0 : linear->version;
        multiply(evidence, normal);
    }
    return normal;
}

double mukca_evidence_evaluate(mukca_evidence *evidence, const mukca_normal_equations *normal,
                               double sigma, double *mean)
{
    mukca_posterior *posterior = &evidence->posterior;
    double log_variance = 0;
    const int n = evidence->linear->n_columns, stride = evidence->linear->stride;
    mukca_posterior_start(posterior, normal->all_gram, n, stride, 1 / (sigma * sigma));
    for (int p = 0; p < normal->n_pairs; p++) {
        const double variance = sigma * sigma * normal->variance[p];
        mukca_posterior_add(posterior, normal->all_distance + p * stride, 1 / variance);
        log_variance += log(variance);
    }
    if (!mukca_posterior_solve(posterior, mean)) return -HUGE_VAL;
    return -0.5 * posterior->quadratic - posterior->log_det - normal->whitening.dof * log(sigma) -
           0.5 * log_variance + normal->whitening.log_det;
}
