/* Evidence of the linearised model: normal equations, posterior.
 *
 * The evidence of a linear model with Gaussian priors and noise has a closed form; the means of the
 * sockets are integrated out with a flat prior.  (C. M. Bishop, Pattern Recognition and Machine
 * Learning, 2006, section 3.5.) */
#include "diagnose/evidence.h"

#include <math.h>
#include <string.h>

#include "base/clones.h"
#include "math/dense.h"

const double mukca_evidence_rho[MUKCA_RHOS] = {0.0, 0.25, 0.5};

bool mukca_evidence_create(mukca_evidence *evidence, mukca_pool *pool,
                           const mukca_recording *recording, const mukca_unknowns *unknowns)
{
    const int capacity = mukca_unknowns_capacity(unknowns), size = capacity + 1;
    const int pairs = recording->data->n_distances + 1, rows = recording->data->n_rows;
    for (int i = 0; i < MUKCA_RHOS; i++)
        evidence->normal[i] = (mukca_normal_equations){
            .rho = mukca_evidence_rho[i],
            .distance_sigma = recording->options.distance_sigma,
            .gram = MUKCA_TAKE(pool, double, size *size),
            .distance = MUKCA_TAKE(pool, double, pairs *size),
            .variance = MUKCA_TAKE(pool, double, pairs),
            .diagonal = MUKCA_TAKE(pool, double, rows),
            .off = MUKCA_TAKE(pool, double, rows),
            .mean_weight = MUKCA_TAKE(pool, double, rows),
            .ones = MUKCA_TAKE(pool, double, recording->data->n_sockets + 2),
            .weighted = MUKCA_TAKE(pool, double, (size_t)(rows * recording->dim) * (size_t)size),
            .all_gram = MUKCA_TAKE(pool, double, size *size),
            .all_distance = MUKCA_TAKE(pool, double, pairs *size),
            .at = MUKCA_TAKE(pool, int, size),
            .reduced_prior = MUKCA_TAKE(pool, double, size),
            .T = MUKCA_TAKE(pool, double, 4 * size),
            .B = MUKCA_TAKE(pool, double, size *size)};
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

/* Compute W for the samples in use and their robust weights (NULL: none), and the terms of the
 * evidence that depend on W alone. */
static void lay_out(mukca_normal_equations *normal, const mukca_recording *r, const double *weight)
{
    const double rho = normal->rho, root = sqrt(1 - rho * rho), part = sqrt(r->share);
    normal->n_pairs = r->n_pairs;
    normal->log_det = 0;
    normal->dof = 0;
    memset(normal->variance, 0, sizeof *normal->variance * (size_t)r->n_pairs);
    for (int g = 0; g < r->n_groups; g++) {
        const mukca_group *group = &r->groups[g];
        double sum = 0;
        if (!group->count) continue;
        for (int k = 0; k < group->count; k++) {
            const int i = group->start + k;
            const double w = part * (weight ? weight[r->order[i]] : 1);
            double own, before;
            mukca_evidence_whitening(&own, &before, k, root, rho);
            own *= w, before *= w;
            normal->diagonal[i] = own * own;
            normal->off[i] = -own * before;
            normal->mean_weight[i] = own * (own - before);
            sum += (own - before) * (own - before);
            if (!k) continue;
            normal->diagonal[i - 1] += before * before;
            normal->mean_weight[i - 1] -= before * (own - before);
        }
        normal->ones[g] = sum;
        for (int k = 0; k < group->count; k++) normal->mean_weight[group->start + k] /= sum;
        normal->log_det -= 0.5 * r->share * r->dim * (group->count - 1) * log(1 - rho * rho);
        normal->dof += (int)lround(r->share * r->dim * group->count);
        if (group->socket < 0) continue;
        normal->dof -= 3;
        normal->log_det -= 0.5 * 3 * log(sum);
        for (int p = 0; p < r->n_pairs; p++)
            if (r->pairs[p].a == g || r->pairs[p].b == g) normal->variance[p] += 1 / sum;
    }
}

/* Coordinate c of a socket's samples: subtract the mean from the weighted columns, and add it to
 * the distances. */
MUKCA_INLINE void centre(const mukca_weighing *x, const mukca_normal_equations *normal,
                         const mukca_recording *r, const mukca_linearisation *linear, int g, int c)
{
    enum { BLOCK = 64 };
    const mukca_group *group = &r->groups[g];
    const size_t step = (size_t)r->dim * (size_t)x->ld;
    for (int start = 0; start < x->n; start += BLOCK) {
        const int count = x->n - start < BLOCK ? x->n - start : BLOCK;
        const size_t at =
            ((size_t)group->start * (size_t)r->dim + (size_t)c) * (size_t)x->ld + (size_t)start;
        double mean[BLOCK] = {0};
        for (int i = 0; i < group->count; i++) {
            const double w = normal->mean_weight[group->start + i],
                         *row = x->x + at + (size_t)i * step;
            for (int k = 0; k < count; k++) mean[k] += w * row[k];
        }
        for (int i = 0; i < group->count; i++) {
            const double w = normal->ones[g] * normal->mean_weight[group->start + i];
            double *row = x->weighted + at + (size_t)i * step;
            for (int k = 0; k < count; k++) row[k] -= w * mean[k];
        }
        for (int p = 0; p < r->n_pairs; p++) {
            const double direction = linear->direction[p][c], w = r->pairs[p].a == g   ? direction
                                                                  : r->pairs[p].b == g ? -direction
                                                                                       : 0;
            double *along = x->along + p * x->ld + start;
            for (int k = 0; k < count && w != 0; k++) along[k] += w * mean[k];
        }
    }
}

MUKCA_CLONES void mukca_evidence_weigh(const mukca_weighing *x,
                                       const mukca_normal_equations *normal,
                                       const mukca_recording *r, const mukca_linearisation *linear)
{
    const size_t ld = (size_t)x->ld, step = (size_t)r->dim * ld;
    for (int g = 0; g < r->n_groups; g++) {
        const mukca_group *group = &r->groups[g];
        for (int i = group->start; i < group->start + group->count; i++) {
            const double diagonal = normal->diagonal[i], before = normal->off[i],
                         after = i + 1 < group->start + group->count ? normal->off[i + 1] : 0;
            for (int c = 0; c < r->dim; c++) {
                const double *row = x->x + (size_t)i * step + (size_t)c * ld;
                double *out = x->weighted + (size_t)i * step + (size_t)c * ld;
                for (int k = 0; k < x->n; k++) out[k] = diagonal * row[k];
                for (int k = 0; k < x->n && before < 0; k++) out[k] += before * (row - step)[k];
                for (int k = 0; k < x->n && after < 0; k++) out[k] += after * (row + step)[k];
            }
        }
        for (int c = 0; c < 3 && group->socket >= 0; c++) centre(x, normal, r, linear, g, c);
    }
}

/* Compute the missing products of the stored columns; `scratch` is [stride][stride]. */
static void extend(mukca_normal_equations *normal, const mukca_recording *r,
                   const mukca_linearisation *linear, double *scratch)
{
    const int done = normal->done, held = linear->n_stored, k = held - done, ld = linear->stride;
    if (!k) return;
    for (int p = 0; p < r->n_pairs; p++)
        memcpy(normal->all_distance + p * ld + done, linear->pair_columns + p * ld + done,
               sizeof(double) * (size_t)k);
    mukca_evidence_weigh(&(mukca_weighing){.n = k,
                                           .ld = ld,
                                           .x = linear->columns + done,
                                           .weighted = normal->weighted + done,
                                           .along = normal->all_distance + done},
                         normal, r, linear);
    const mukca_columns x = {linear->columns + done, k, ld}, w = {normal->weighted, held, ld};
    memset(scratch, 0, sizeof *scratch * (size_t)(k * held));
    if (done)
        mukca_dense_xty(scratch, x, w, r->n_samples * r->dim);
    else
        mukca_dense_symmetric(scratch, x, w, r->n_samples * r->dim);
    for (int i = 0; i < k; i++)
        for (int j = 0; j < held; j++)
            normal->all_gram[(done + i) * ld + j] = normal->all_gram[j * ld + done + i] =
                scratch[i * held + j];
    normal->done = held;
}

mukca_normal_equations *mukca_evidence_collect(mukca_evidence *evidence, int index,
                                               const mukca_recording *recording,
                                               const mukca_unknowns *unknowns,
                                               const mukca_linearisation *linear)
{
    mukca_normal_equations *normal = &evidence->normal[index];
    const int size = linear->n_columns + 1, ld = linear->stride, *at = linear->at;
    bool same = normal->n + 1 == size && memcmp(normal->at, at, sizeof *at * (size_t)size) == 0;
    if (unknowns->weight || normal->version != linear->version) {
        same = false;
        lay_out(normal, recording, unknowns->weight);
        normal->done = 0;
        normal->version = unknowns->weight ? 0 : linear->version;
    } else if (normal->stride != ld) {
        const mukca_strides strides = {.columns = normal->done, .old = normal->stride, .new = ld};
        mukca_linearisation_spread(normal->weighted, recording->n_samples * recording->dim,
                                   &strides);
        mukca_linearisation_spread(normal->all_gram, normal->done, &strides);
        mukca_linearisation_spread(normal->all_distance, recording->n_pairs, &strides);
    }
    normal->stride = ld;
    extend(normal, recording, linear, evidence->marginal);
    if (same) return normal;
    normal->n = linear->n_columns;
    normal->reduced = false;
    memcpy(normal->at, at, sizeof *at * (size_t)size);
    for (int i = 0; i < size; i++)
        for (int j = 0; j < size; j++)
            normal->gram[i * size + j] = normal->all_gram[at[i] * ld + at[j]];
    for (int p = 0; p < normal->n_pairs; p++)
        for (int i = 0; i < size; i++)
            normal->distance[p * size + i] = normal->all_distance[p * ld + at[i]];
    return normal;
}

MUKCA_CLONES double mukca_evidence_evaluate(mukca_evidence *evidence,
                                            const mukca_normal_equations *normal, double sigma,
                                            double *mean)
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
