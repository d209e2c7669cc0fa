/* Posterior of the coefficients of a linear Gaussian model. */
#include "infer/posterior.h"

#include <math.h>
#include <string.h>

#include "base/clones.h"
#include "math/dense.h"

void mukca_posterior_take(mukca_posterior *p, mukca_pool *pool, int n)
{
    p->prior = MUKCA_TAKE(pool, double, n + 1);
    p->factor = MUKCA_TAKE(pool, double, n *n + 1);
    p->work = MUKCA_TAKE(pool, double, n + 1);
}

MUKCA_CLONES void mukca_posterior_start(mukca_posterior *p, const double *gram, int n, int width,
                                        double precision)
{
    const double *values = gram + (width - 1) * width;
    p->n = n;
    p->value = width - 1;
    p->quadratic = precision * values[p->value];
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) p->factor[i * n + j] = precision * gram[i * width + j];
        p->work[i] = precision * values[i];
    }
}

MUKCA_CLONES void mukca_posterior_add(mukca_posterior *p, const double *row, double precision)
{
    const int n = p->n;
    const double value = row[p->value];
    p->quadratic += precision * value * value;
    for (int i = 0; i < n; i++) {
        p->work[i] += precision * row[i] * value;
        for (int j = 0; j <= i; j++) p->factor[i * n + j] += precision * row[i] * row[j];
    }
}

MUKCA_CLONES bool mukca_posterior_solve(mukca_posterior *p, double *mean)
{
    const int n = p->n;
    double *L = p->factor, *z = p->work;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) L[i * n + j] *= p->prior[i] * p->prior[j];
        L[i * n + i] += 1;
        z[i] *= p->prior[i];
    }
    if (!mukca_dense_cholesky(L, n)) return false;
    mukca_dense_forward(z, 1, L, n);
    p->log_det = 0;
    for (int i = 0; i < n; i++) {
        p->quadratic -= z[i] * z[i];
        p->log_det += log(L[i * n + i]);
    }
    if (!mean) return true;
    memcpy(mean, z, sizeof *mean * (size_t)n);
    mukca_dense_backward(mean, 1, L, n);
    for (int i = 0; i < n; i++) mean[i] *= p->prior[i];
    return true;
}

double mukca_posterior_variance(double *row, const mukca_posterior *p)
{
    for (int i = 0; i < p->n; i++) row[i] *= p->prior[i];
    return mukca_dense_variance(row, p->factor, p->n);
}

/* ---- positions in groups ---- */

bool mukca_grouped_create(mukca_grouped *g, mukca_pool *pool, int n, int groups, int pairs)
{
    const int size = n + 1;
    *g = (mukca_grouped){.posterior.n = n,
                         .size = size,
                         .n_groups = groups,
                         .n_pairs = pairs,
                         .pair = MUKCA_TAKE(pool, mukca_group_pair, pairs + 1),
                         .gram = MUKCA_TAKE(pool, double, size *size),
                         .sum = MUKCA_TAKE(pool, double, groups * 3 * size + 1),
                         .count = MUKCA_TAKE(pool, int, groups + 1),
                         .row = MUKCA_TAKE(pool, double, size),
                         .common = MUKCA_TAKE(pool, double, size)};
    mukca_posterior_take(&g->posterior, pool, n);
    for (int i = 0; i < n && !pool->failed; i++) g->posterior.prior[i] = 1;
    return !pool->failed;
}

MUKCA_CLONES void mukca_grouped_add(mukca_grouped *g, const double *x, int group, int sign)
{
    const int size = g->size;
    double *sum = g->sum + group * 3 * size;
    g->count[group] += sign;
    for (int i = 0; i < 3 * size; i++) sum[i] += sign * x[i];
    for (int a = 0; a < 3; a++, x += size)
        for (int r = 0; r < size; r++) {
            const double f = sign * x[r];
            for (int c = 0; c <= r && f != 0; c++) g->gram[r * size + c] += f * x[c];
        }
}

/* row[n]: derivatives of the distance of a pair; variance: of the latter, by the positions.  False:
 * one has no position. */
static bool pair_row(double *row, double *variance, const mukca_grouped *g,
                     const mukca_group_pair *p)
{
    const int size = g->size;
    const double *a = g->sum + p->a * 3 * size, *b = g->sum + p->b * 3 * size;
    const double of_a = 1.0 / g->count[p->a], of_b = 1.0 / g->count[p->b];
    double square = 0;
    if (!isfinite(of_a + of_b)) return false;
    memset(row, 0, sizeof *row * (size_t)size);
    for (int i = 0; i < 3; i++, a += size, b += size) {
        const double u = b[size - 1] * of_b - a[size - 1] * of_a;
        square += u * u;
        for (int c = 0; c < size - 1; c++) row[c] += u * (a[c] * of_a - b[c] * of_b);
    }
    const double length = sqrt(square);
    for (int c = 0; c < size - 1; c++) row[c] /= length;
    *variance = g->noise * g->noise * (of_a + of_b);
    return length > 1e-6;
}

/* Add the pairs of an artefact; the error that they share is integrated out. */
static void add_artefact(mukca_grouped *g, int artefact)
{
    double variance, precision = 0, sigma = 0;
    memset(g->common, 0, sizeof *g->common * (size_t)g->size);
    for (int k = 0; k < g->n_pairs; k++) {
        const mukca_group_pair *p = &g->pair[k];
        if (p->artefact != artefact || !pair_row(g->row, &variance, g, p)) continue;
        mukca_posterior_add(&g->posterior, g->row, 1 / variance);
        for (int c = 0; c < g->size; c++) g->common[c] += g->row[c] / variance;
        precision += 1 / variance;
        sigma = p->sigma;
    }
    if (sigma > 0)
        mukca_posterior_add(&g->posterior, g->common, -1 / (precision + 1 / (sigma * sigma)));
}

void mukca_grouped_solve(mukca_grouped *g)
{
    const double precision = 1 / (g->noise * g->noise);
    int artefacts = 0;
    mukca_posterior_start(&g->posterior, g->gram, g->size - 1, g->size, precision);
    for (int k = 0; k < 3 * g->n_groups; k++) {
        const int group = k / 3;
        if (g->count[group] > 0)
            mukca_posterior_add(&g->posterior, g->sum + k * g->size, -precision / g->count[group]);
    }
    for (int k = 0; k < g->n_pairs; k++)
        if (g->pair[k].artefact >= artefacts) artefacts = g->pair[k].artefact + 1;
    for (int a = 0; a < artefacts; a++) add_artefact(g, a);
    mukca_posterior_solve(&g->posterior, NULL); /* positive definite by the priors */
}
