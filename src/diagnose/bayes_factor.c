/* Log Bayes factor of a candidate from its projected normal equations. */
#include "diagnose/bayes_factor.h"

#include <math.h>

#include "math/four.h"
#include "math/stats.h"

/* Four prior sizes at a time, one per lane: 1 + s^2 G = L L', L stored by rows, and x = L^-1 g. */
typedef struct {
    int k;
    double L[MUKCA_MAX_COLUMNS * (MUKCA_MAX_COLUMNS + 1) / 2][4], x[MUKCA_MAX_COLUMNS][4];
} four_factors;

/* Entry i of x, from the preceding ones. */
MUKCA_INLINE void solve_row(four_factors *f, const double (*row)[4], int i)
{
    four x = LOAD4(f->x[i]);
    for (int c = 0; c < i; c++) x -= LOAD4(row[c]) * LOAD4(f->x[c]);
    STORE4(f->x[i], x / LOAD4(row[i]));
}

/* A pivot that is not positive results in NaN. */
MUKCA_CLONES static void factor_four(four_factors *f, const double *G, const double s2[4])
{
    const four s = LOAD4(s2);
    double(*row)[4] = f->L;
    for (int i = 0; i < f->k; row += ++i) {
        double(*other)[4] = f->L;
        for (int j = 0; j <= i; other += ++j) {
            four sum = s * G[i * f->k + j];
            if (i == j) sum += 1;
            for (int c = 0; c < j; c++) sum -= LOAD4(row[c]) * LOAD4(other[c]);
            if (i != j) sum /= LOAD4(other[j]);
            STORE4(row[j], sum);
        }
        for (int l = 0; l < 4; l++) row[i][l] = sqrt(row[i][l]);
        solve_row(f, (const double(*)[4])row, i);
    }
}

/* One lane: x := L^-1 x, and x := L'^-1 x. */
static void solve_forward(double *x, const four_factors *f, int lane)
{
    const double(*row)[4] = (const double(*)[4])f->L;
    for (int i = 0; i < f->k; row += ++i) {
        for (int c = 0; c < i; c++) x[i] -= row[c][lane] * x[c];
        x[i] /= row[i][lane];
    }
}

static void solve_backward(double *x, const four_factors *f, int lane)
{
    const double(*row)[4] = (const double(*)[4])f->L + f->k * (f->k + 1) / 2;
    for (int i = f->k - 1; i >= 0; i--) {
        row -= i + 1;
        x[i] /= row[i][lane];
        for (int c = 0; c < i; c++) x[c] -= row[c][lane] * x[i];
    }
}

/* Sum of log L[i][i]. */
static double log_diagonal(const four_factors *f, int lane)
{
    double product = 1, sum = 0;
    for (int i = 0, at = 0; i < f->k; at += ++i + 1) { /* one logarithm for several factors */
        product *= f->L[at][lane];
        if (product > 1e100 || i + 1 == f->k) sum += log(product), product = 1;
    }
    return sum;
}

/* Log posterior probability of an amplitude below the prior's bound.  s2 x: the posterior mean. */
static double log_admitted(const four_factors *f, int lane, const double *x,
                           const mukca_candidate *h, double s2, double noise)
{
    const double largest = mukca_candidate_largest(h);
    double amplitude = 0, variance = 0, radial[MUKCA_MAX_COLUMNS];
    for (int i = 0; i < h->terms; i++) amplitude += pow(s2 * x[i] / h->unit[i], 2);
    amplitude = sqrt(amplitude);
    if (amplitude < 0.5 * largest) return 0; /* close to 1 */
    for (int i = 0; i < h->terms; i++)
        radial[i] = s2 * x[i] / (h->unit[i] * h->unit[i] * amplitude);
    solve_forward(radial, f, lane);
    for (int i = 0; i < h->terms; i++) variance += s2 * radial[i] * radial[i];
    return mukca_stats_log_normal_cdf((largest - amplitude) / sqrt(variance * noise));
}

/* Log posterior probability of a positive first coefficient. */
static double log_positive(const four_factors *f, int lane, double mean, double s2, double noise)
{
    double first[MUKCA_MAX_COLUMNS] = {1}, variance = 0;
    solve_forward(first, f, lane);
    for (int i = 0; i < f->k; i++) variance += s2 * first[i] * first[i];
    return mukca_stats_log_normal_cdf(s2 * mean / sqrt(variance * noise));
}

double mukca_bayes_factor_average(double *G, double *g, const mukca_candidate *h, double residual,
                                  int dof, double *information)
{
    const int k = h->terms;
    double value[MUKCA_MAX_SIZES], scales[MUKCA_MAX_SIZES], weight[MUKCA_MAX_SIZES];
    const int n_scales = mukca_candidate_scales(scales, weight, h);
    const bool nonnegative =
        h->kind == MUKCA_CANDIDATE_EFFECT && mukca_effect_table[h->effect.kind]->nonnegative;
    const bool bounded = mukca_candidate_largest(h) < HUGE_VAL;
    double trace = 0;
    if (k < 1) return -HUGE_VAL; /* no effect on these data */
    for (int i = 0; i < k; i++) g[i] /= h->unit[i];
    for (int i = 0; i < k; i++)
        for (int j = 0; j <= i; j++)
            G[i * k + j] = 0.5 * (G[i * k + j] + G[j * k + i]) / (h->unit[i] * h->unit[j]);
    /* terms after the effect's own are deviations of the masses */
    const int own = mukca_candidate_own_terms(h);
    for (int i = 0; i < own; i++) trace = fmax(trace, G[i * k + i]);
    if (information) *information = trace;
    four_factors f;
    f.k = k;
    for (int s = 0; s < n_scales; s++) {
        const double s2 = scales[s] * scales[s];
        const int lane = s % 4;
        double q = 0, x[MUKCA_MAX_COLUMNS];
        if (lane == 0) {
            double squares[4] = {0};
            for (int l = 0; l < 4 && s + l < n_scales; l++)
                squares[l] = scales[s + l] * scales[s + l];
            for (int i = 0; i < k; i++)
                for (int l = 0; l < 4; l++) f.x[i][l] = g[i];
            factor_four(&f, G, squares);
        }
        for (int i = 0; i < k; i++) q += s2 * f.x[i][lane] * f.x[i][lane];
        if (isnan(q)) return -HUGE_VAL;
        q = fmin(q, 0.9999 * residual);
        value[s] = weight[s] - log_diagonal(&f, lane) - 0.5 * dof * log1p(-q / residual);
        if (!nonnegative && !bounded) continue;
        const double noise = fmax((residual - q) / dof, 1e-6);
        for (int i = 0; i < k; i++) x[i] = f.x[i][lane];
        solve_backward(x, &f, lane);
        if (bounded) value[s] += log_admitted(&f, lane, x, h, s2, noise);
        if (nonnegative) value[s] += log(2) + log_positive(&f, lane, x[0], s2, noise);
    }
    return mukca_stats_log_sum_exp(value, n_scales);
}
