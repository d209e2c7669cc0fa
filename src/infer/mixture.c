/* Evidence of a block of coefficients whose prior is a mixture of sizes.
 *
 * For one size s, the log Bayes factor is -log |1 + s^2 G| / 2 - nu / 2 log(1 - q / Q) with
 * q = s^2 g' (1 + s^2 G)^-1 g: the evidence of Bishop, Pattern Recognition and Machine Learning,
 * 2006, section 3.5, with the scale of the noise at its maximum. */
#include "infer/mixture.h"

#include <math.h>
#include <string.h>

#include "math/four.h"
#include "math/stats.h"

/* Four prior sizes at a time, one per lane: 1 + s^2 G = L L', L stored by rows, and x = L^-1 g. */

/* Entry i of x, from the preceding ones. */
MUKCA_INLINE void solve_row(mukca_mixture_scratch *f, const double (*row)[4], int i)
{
    four x = LOAD4(f->x[i]);
    for (int c = 0; c < i; c++) x -= LOAD4(row[c]) * LOAD4(f->x[c]);
    STORE4(f->x[i], x / LOAD4(row[i]));
}

/* Row i of L, which begins there. */
MUKCA_INLINE double (*row_of(mukca_mixture_scratch *f, int i))[4]
{
    return f->L + i * (i + 1) / 2;
}

/* Entries [from, i] of row i.  A pivot that is not positive results in NaN. */
MUKCA_INLINE void factor_row(mukca_mixture_scratch *f, int i, int from, const double *G, four s)
{
    double(*row)[4] = row_of(f, i);
    for (int j = from; j <= i; j++) {
        const double(*other)[4] = (const double(*)[4])row_of(f, j);
        four sum = s * G[j];
        if (i == j) sum += 1;
        for (int c = 0; c < j; c++) sum -= LOAD4(row[c]) * LOAD4(other[c]);
        if (i != j) sum /= LOAD4(other[j]);
        STORE4(row[j], sum);
    }
    for (int l = 0; l < 4; l++) row[i][l] = sqrt(row[i][l]);
}

/* Four rows at a time: the subtractions from one sum are sequential. */
MUKCA_CLONES static void factor_four(mukca_mixture_scratch *f, int k, const double *G,
                                     const double s2[4])
{
    const four s = LOAD4(s2);
    for (int first = 0; first < k; first += 4) {
        double(*row[4])[4];
        const double *g[4];
        for (int r = 0; r < 4; r++) { /* beyond the last row: the last row again */
            const int i = first + r < k ? first + r : k - 1;
            row[r] = row_of(f, i), g[r] = G + i * k;
        }
        for (int j = 0; j < first; j++) {
            const double(*other)[4] = (const double(*)[4])row_of(f, j);
            four a0 = s * g[0][j], a1 = s * g[1][j], a2 = s * g[2][j], a3 = s * g[3][j];
            for (int c = 0; c < j; c++) {
                const four o = LOAD4(other[c]);
                a0 -= LOAD4(row[0][c]) * o;
                a1 -= LOAD4(row[1][c]) * o;
                a2 -= LOAD4(row[2][c]) * o;
                a3 -= LOAD4(row[3][c]) * o;
            }
            const four pivot = LOAD4(other[j]);
            STORE4(row[0][j], a0 / pivot);
            STORE4(row[1][j], a1 / pivot);
            STORE4(row[2][j], a2 / pivot);
            STORE4(row[3][j], a3 / pivot);
        }
        for (int i = first; i < first + 4 && i < k; i++) {
            factor_row(f, i, first, G + i * k, s);
            solve_row(f, (const double(*)[4])row_of(f, i), i);
        }
    }
}

/* One lane: x := L^-1 x. */
static void solve_forward(double *x, const mukca_mixture_scratch *f, int k, int lane)
{
    const double(*row)[4] = (const double(*)[4])f->L;
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
    for (int s = 0; s < prior->n_sizes; s++) {
        const double s2 = prior->size[s] * prior->size[s];
        const int lane = s % 4;
        double q = 0;
        if (lane == 0) {
            double squares[4] = {0};
            for (int l = 0; l < 4 && s + l < prior->n_sizes; l++)
                squares[l] = prior->size[s + l] * prior->size[s + l];
            for (int i = 0; i < k; i++)
                for (int l = 0; l < 4; l++) f->x[i][l] = e->g[i];
            factor_four(f, k, e->G, squares);
        }
        for (int i = 0; i < k; i++) q += s2 * f->x[i][lane] * f->x[i][lane];
        q = fmin(q, most * residual);
        value[s] =
            prior->log_weight[s] - log_diagonal(f, k, lane) - 0.5 * dof * log1p(-q / residual);
        if (prior->nonnegative) value[s] += log_positive(f, k, lane, s2, residual - q, dof);
        if (isnan(value[s])) value[s] = -HUGE_VAL; /* not positive definite */
    }
    if (by_size) memcpy(by_size, value, sizeof *value * (size_t)prior->n_sizes);
    return mukca_stats_log_sum_exp(value, prior->n_sizes);
}
