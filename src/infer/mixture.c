/* Evidence of a block of coefficients whose prior is a mixture of sizes.
 *
 * For one size s, the log Bayes factor is -log |1 + s^2 G| / 2 - nu / 2 log(1 - q / Q) with
 * q = s^2 g' (1 + s^2 G)^-1 g: the evidence of Bishop, Pattern Recognition and Machine Learning,
 * 2006, section 3.5, with the scale of the noise at its maximum. */
#include "infer/mixture.h"

#include <math.h>
#include <string.h>

#include "base/kernel.h"
#include "math/stats.h"

/* Several prior sizes at a time, one per lane: 1 + s^2 G = L L', L stored by rows, and x = L^-1 g.
 */
#define ROW(L, i) ((L) + (i) * ((i) + 1) / 2)
#define LOAD(x) (*(const VECTOR *)(const void *)(x))
#define STORE(x, value) (*(VECTOR *)(void *)(x) = (value))
#define LANES 2
#define VECTOR pair
#define LANES_OF(name) name##_pair
#include "infer/mixture_lanes.h"
#undef LANES
#undef VECTOR
#undef LANES_OF
#define LANES 4
#define VECTOR four
#define LANES_OF(name) name##_four
#include "infer/mixture_lanes.h"
#undef LANES
#undef VECTOR
#undef LANES_OF
#define LANES 8
#define VECTOR eight
#define LANES_OF(name) name##_eight
#include "infer/mixture_lanes.h"

MUKCA_INLINE void factor_any(mukca_mixture_scratch *f, int k, const double *G,
                             const mukca_mixture *prior, int width)
{
    double s2[MUKCA_MOST_SIZES] = {0};
    for (int s = 0; s < prior->n_sizes; s++) s2[s] = prior->size[s] * prior->size[s];
    if (width == 8 && prior->n_sizes > 4)
        factor_eight(f, k, G, s2, 0);
    else if (width > 2)
        for (int s = 0; s < prior->n_sizes; s += 4) factor_four(f, k, G, s2, s);
    else
        for (int s = 0; s < prior->n_sizes; s += 2) factor_pair(f, k, G, s2, s);
}

MUKCA_KERNEL(static, factor,
             (mukca_mixture_scratch * f, int k, const double *G, const mukca_mixture *prior), f, k,
             G, prior)

/* One lane: x := L^-1 x. */
static void solve_forward(double *x, const mukca_mixture_scratch *f, int k, int lane)
{
    const double(*row)[MUKCA_MOST_SIZES] = (const double(*)[MUKCA_MOST_SIZES])f->L;
    for (int i = 0; i < k; row += ++i) {
        for (int c = 0; c < i; c++) x[i] -= row[c][lane] * x[c];
        x[i] /= row[i][lane];
    }
}

/* Sum of log L[i][i]. */
static double log_diagonal(const mukca_mixture_scratch *f, int k, int lane)
{
    double product = 1, sum = 0;
    for (int i = 0, at = 0; i < k; at += ++i + 1) { /* one logarithm for several factors */
        product *= f->L[at][lane];
        if (product > 1e100 || i + 1 == k) sum += log(product), product = 1;
    }
    return sum;
}

double mukca_mixture_positive(double mean, double variance, double residual, int dof)
{
    const double noise = fmax(residual / dof, 1e-6);
    return log(2) + mukca_stats_log_normal_cdf(mean / sqrt(fmax(variance, 1e-300) * noise));
}

/* The same for the first coefficient at the size sqrt(s2). */
static double log_positive(const mukca_mixture_scratch *f, int k, int lane, double s2,
                           double residual, int dof)
{
    double first[MUKCA_MOST_TERMS] = {1}, mean = 0, variance = 0;
    solve_forward(first, f, k, lane);
    for (int i = 0; i < k; i++) {
        mean += s2 * first[i] * f->x[i][lane];
        variance += s2 * first[i] * first[i];
    }
    return mukca_mixture_positive(mean, variance, residual, dof);
}

double mukca_mixture_evidence(double *by_size, const mukca_equations *e, const mukca_mixture *prior,
                              mukca_mixture_scratch *f)
{
    const int k = e->terms, dof = e->dof;
    const double residual = e->residual;
    /* at most this share of the residual is explained: rounding of a perfect fit */
    const double most = 0.9999;
    double value[MUKCA_MOST_SIZES];
    for (int i = 0; i < k; i++)
        for (int l = 0; l < MUKCA_MOST_SIZES; l++) f->x[i][l] = e->g[i];
    factor(f, k, e->G, prior);
    for (int s = 0; s < prior->n_sizes; s++) {
        const double s2 = prior->size[s] * prior->size[s];
        double q = 0;
        for (int i = 0; i < k; i++) q += s2 * f->x[i][s] * f->x[i][s];
        q = fmin(q, most * residual);
        value[s] = prior->log_weight[s] - log_diagonal(f, k, s) - 0.5 * dof * log1p(-q / residual);
        if (prior->nonnegative) value[s] += log_positive(f, k, s, s2, residual - q, dof);
        if (isnan(value[s])) value[s] = -HUGE_VAL; /* not positive definite */
    }
    if (by_size) memcpy(by_size, value, sizeof *value * (size_t)prior->n_sizes);
    return mukca_stats_log_sum_exp(value, prior->n_sizes);
}
