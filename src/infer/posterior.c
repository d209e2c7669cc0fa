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

MUKCA_CLONES bool mukca_posterior_solve(mukca_posterior *p, const double *centre, double *mean)
{
    const int n = p->n;
    double *L = p->factor, *z = p->work;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) L[i * n + j] *= p->prior[i] * p->prior[j];
        L[i * n + i] += 1;
        z[i] = z[i] * p->prior[i] + (centre ? centre[i] / p->prior[i] : 0);
    }
    if (mukca_dense_cholesky(L, n)) return false;
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

/* ---- observations in groups ---- */

enum { BLOCK = 96 }; /* rows multiplied together: they and the product stay in cache */

bool mukca_grouped_create(mukca_grouped *g, mukca_pool *pool, int n, int groups, int pairs)
{
    const int size = n + 1, width = MUKCA_OWN + size;
    *g = (mukca_grouped){.posterior.n = n,
                         .width = width,
                         .n_groups = groups,
                         .n_pairs = pairs,
                         .pair = MUKCA_TAKE(pool, mukca_group_pair, pairs + 1),
                         .gram = MUKCA_TAKE(pool, double, size *size),
                         .own = MUKCA_TAKE(pool, double, groups *MUKCA_OWN *width),
                         .weight = MUKCA_TAKE(pool, double, groups + 1),
                         .reduced = MUKCA_TAKE(pool, double, groups *MUKCA_OWN *width),
                         .row = MUKCA_TAKE(pool, double, size),
                         .common = MUKCA_TAKE(pool, double, size),
                         .block = MUKCA_TAKE(pool, double, BLOCK *size),
                         .mean = MUKCA_TAKE(pool, double, size),
                         .solution = MUKCA_TAKE(pool, double, groups *MUKCA_OWN + 1)};
    mukca_posterior_take(&g->posterior, pool, n);
    for (int i = 0; i < n && !pool->failed; i++) g->posterior.prior[i] = 1;
    return !pool->failed;
}

void mukca_grouped_clear(mukca_grouped *g)
{
    const int size = g->posterior.n + 1;
    memset(g->gram, 0, sizeof *g->gram * (size_t)(size * size));
    memset(g->own, 0, sizeof *g->own * (size_t)(g->n_groups * MUKCA_OWN * g->width));
    memset(g->weight, 0, sizeof *g->weight * (size_t)g->n_groups);
}

/* Add the products with the own columns. */
MUKCA_CLONES static void add_own(mukca_grouped *g, const double *x, int group, double weight)
{
    const int w = g->width;
    double *own = g->own + group * MUKCA_OWN * w;
    g->weight[group] += weight;
    for (int a = 0; a < 3; a++, x += w)
        for (int r = 0; r < MUKCA_OWN; r++) {
            const double f = weight * x[r];
            for (int c = r; c < w && f != 0; c++) own[r * w + c] += f * x[c];
        }
}

MUKCA_CLONES void mukca_grouped_add(mukca_grouped *g, const double *x, int group, double weight)
{
    const int size = g->posterior.n + 1;
    add_own(g, x, group, weight);
    for (int a = 0; a < 3; a++, x += g->width) {
        const double *y = x + MUKCA_OWN;
        for (int r = 0; r < size; r++) {
            const double f = weight * y[r];
            for (int c = 0; c <= r && f != 0; c++) g->gram[r * size + c] += f * y[c];
        }
    }
}

void mukca_grouped_add_all(mukca_grouped *g, const mukca_observation *list, int n)
{
    const int size = g->posterior.n + 1;
    int rows = 0;
    for (int i = 0; i < n; i++) {
        const double root = sqrt(list[i].weight);
        add_own(g, list[i].x, list[i].group, list[i].weight);
        for (int a = 0; a < 3; a++, rows++) {
            const double *y = list[i].x + a * g->width + MUKCA_OWN;
            for (int c = 0; c < size; c++) g->block[rows * size + c] = root * y[c];
        }
        if (rows + 3 <= BLOCK && i + 1 < n) continue;
        mukca_dense_syrk(g->gram, size, g->block, rows, size);
        rows = 0;
    }
}

/* Is an own column of a group, without the components along those before it, not 0? */
static bool determined(const mukca_grouped *g, int group, int column)
{
    const double *own = g->reduced + group * MUKCA_OWN * g->width;
    return own[column * g->width + column] > 1e-9 * g->weight[group];
}

/* Eliminate the own unknowns of a group: subtract the components of all columns along its own. */
static void eliminate(mukca_grouped *g, int group)
{
    const int w = g->width;
    double *own = g->reduced + group * MUKCA_OWN * w;
    for (int b = 0; b < MUKCA_OWN; b++) {
        const double *by = own + b * w;
        if (!determined(g, group, b)) continue;
        for (int r = b + 1; r < MUKCA_OWN; r++) {
            const double f = by[r] / by[b];
            for (int c = r; c < w && f != 0; c++) own[r * w + c] -= f * by[c];
        }
        mukca_posterior_add(&g->posterior, by + MUKCA_OWN, -1 / (by[b] * g->noise * g->noise));
    }
}

bool mukca_grouped_pair(double *row, double *variance, const mukca_grouped *g, int pair)
{
    const mukca_group_pair *p = &g->pair[pair];
    const int w = g->width, n = g->posterior.n;
    const double *a = g->own + MUKCA_OWN * (p->a * w + 1), *b = g->own + MUKCA_OWN * (p->b * w + 1);
    const double of_a = 1 / g->weight[p->a], of_b = 1 / g->weight[p->b];
    double u[3], square = 0;
    if (!isfinite(of_a + of_b)) return false;
    for (int i = 0, y = n; i < 3; i++, y += w) {
        u[i] = b[y] * of_b - a[y] * of_a;
        square += u[i] * u[i];
    }
    const double length = sqrt(square);
    for (int c = 0; c < n; c++) {
        row[c] = 0;
        for (int i = 0, x = c; i < 3; i++, x += w)
            row[c] += u[i] / length * (a[x] * of_a - b[x] * of_b);
    }
    row[n] = p->distance - length;
    *variance = g->noise * g->noise * (of_a + of_b);
    return length > 1e-6;
}

/* Add the pairs of an artefact; the error that they share is eliminated. */
static void add_artefact(mukca_grouped *g, int artefact, int pairs)
{
    const int n = g->posterior.n;
    double variance, precision = 0, sigma = 0;
    memset(g->common, 0, sizeof *g->common * (size_t)(n + 1));
    for (int k = 0; k < g->n_pairs; k++) {
        const mukca_group_pair *p = &g->pair[k];
        if (!p->used || p->artefact != artefact || !mukca_grouped_pair(g->row, &variance, g, k))
            continue;
        const double length = p->distance - g->row[n];
        mukca_posterior_add(&g->posterior, g->row, 1 / variance);
        for (int c = 0; c < n; c++) g->posterior.work[c] += g->misfit / pairs / length * g->row[c];
        for (int c = 0; c <= n; c++) g->common[c] += g->row[c] / variance;
        precision += 1 / variance;
        sigma = p->sigma;
    }
    if (sigma > 0)
        mukca_posterior_add(&g->posterior, g->common, -1 / (precision + 1 / (sigma * sigma)));
}

static void add_pairs(mukca_grouped *g)
{
    int pairs = 0, artefacts = 0;
    for (int k = 0; k < g->n_pairs; k++) {
        pairs += g->pair[k].used;
        if (g->pair[k].artefact >= artefacts) artefacts = g->pair[k].artefact + 1;
    }
    for (int a = 0; a < artefacts; a++) add_artefact(g, a, pairs);
}

/* Own unknowns of a group at the mean of the coefficients. */
static void solve_own(mukca_grouped *g, int group)
{
    const int w = g->width;
    double *own = g->solution + group * MUKCA_OWN;
    for (int k = MUKCA_OWN - 1; k >= 0; k--) {
        const double *row = g->reduced + (group * MUKCA_OWN + k) * w;
        double sum = row[w - 1];
        own[k] = 0;
        if (!determined(g, group, k)) continue;
        for (int j = k + 1; j < MUKCA_OWN; j++) sum -= row[j] * own[j];
        for (int i = 0; i < g->posterior.n; i++) sum -= row[MUKCA_OWN + i] * g->mean[i];
        own[k] = sum / row[k];
        g->n_own++;
    }
}

void mukca_grouped_solve(mukca_grouped *g, const double *centre)
{
    memcpy(g->reduced, g->own, sizeof *g->own * (size_t)(g->n_groups * MUKCA_OWN * g->width));
    mukca_posterior_start(&g->posterior, g->gram, g->posterior.n, g->posterior.n + 1,
                          1 / (g->noise * g->noise));
    for (int k = 0; k < g->n_groups; k++) eliminate(g, k);
    add_pairs(g);
    mukca_posterior_solve(&g->posterior, centre, g->mean); /* positive definite by the priors */
    g->n_own = 0;
    for (int k = 0; k < g->n_groups; k++) solve_own(g, k);
}

double mukca_grouped_residual(double e[3], const mukca_grouped *g, const double *x, int group)
{
    const double *own = g->solution + group * MUKCA_OWN;
    double square = 0;
    for (int a = 0; a < 3; a++, x += g->width) {
        e[a] = -x[g->width - 1];
        for (int k = 0; k < MUKCA_OWN; k++) e[a] += x[k] * own[k];
        for (int i = 0; i < g->posterior.n; i++) e[a] += x[MUKCA_OWN + i] * g->mean[i];
        square += e[a] * e[a];
    }
    return sqrt(square);
}
