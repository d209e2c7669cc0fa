/* Which coefficients a fleet shares: the competition of their means. */
#include <math.h>
#include <string.h>

#include "fleet/population.h"
#include "math/dense.h"
#include "math/stats.h"

enum { T = MUKCA_FLEET_TERMS };

/* Prior sigmas of a mean, rad/(N m): the usual ones of mukca_sizes_spring. */
static const double sizes[] = {10e-6, 30e-6, 100e-6, 300e-6};
enum { SIZES = sizeof sizes / sizeof *sizes };

/* Log odds from which a coefficient is shared: that of a diagnosis' first cause. */
#define THRESHOLD 3.0
#define INTERVAL 1.959963984540054

/* Log Bayes factor of coefficient k besides those of the set (k left out of it). */
static double log_bayes(const mukca_population *p, const bool *set, int k)
{
    const int n = p->n;
    int index[T] = {0}, m = 0;
    double A[T * T] = {0}, b[2 * T], value[SIZES];
    for (int i = 0; i < n; i++)
        if (set[i] && i != k) index[m++] = i;
    for (int i = 0; i < m; i++) {
        for (int j = 0; j <= i; j++) A[i * m + j] = p->information[index[i] * n + index[j]];
        A[i * m + i] += 1 / (sizes[2] * sizes[2]);
        b[2 * i] = p->information[index[i] * n + k], b[2 * i + 1] = p->vector[index[i]];
    }
    double G = p->information[k * n + k], g = p->vector[k];
    if (m && mukca_dense_cholesky(A, m)) return -HUGE_VAL;
    mukca_dense_forward(b, 2, A, m);
    for (int i = 0; i < m; i++) {
        G -= b[2 * i] * b[2 * i];
        g -= b[2 * i] * b[2 * i + 1];
    }
    for (int s = 0; s < SIZES; s++) {
        const double s2 = sizes[s] * sizes[s], d = 1 + s2 * G;
        /* half of the prior has the wrong sign */
        value[s] = -0.5 * log(d) + 0.5 * s2 * g * g / d + log(2) +
                   mukca_stats_log_normal_cdf(sqrt(s2 / d) * g) - log(SIZES);
    }
    return mukca_stats_log_sum_exp(value, SIZES);
}

void mukca_population_describe(mukca_shared *shared, const mukca_population *p,
                               const mukca_fleet *f)
{
    const int n = p->n;
    /* equal prior odds: that there is one more at all, then which */
    const double log_prior = -log(2.0 * n);
    bool set[T] = {false};
    double value[T];
    for (;;) {
        int best = -1;
        for (int k = 0; k < n; k++) {
            value[k] = set[k] ? -HUGE_VAL : log_bayes(p, set, k);
            if (!set[k] && (best < 0 || value[k] > value[best])) best = k;
        }
        if (best < 0 || value[best] + log_prior < THRESHOLD) break;
        set[best] = true;
    }
    for (int k = 0; k < n; k++)
        if (set[k] && log_bayes(p, set, k) + log_prior < THRESHOLD) set[k] = false, k = -1;
    for (int k = 0; k < n; k++) {
        double odds[T + 1] = {0};
        int m = 1, own = 0;
        for (int i = 0; i < n; i++) {
            if (set[i] && i != k) continue;
            bool others[T];
            memcpy(others, set, sizeof others);
            others[k] = false;
            if (i == k) own = m;
            odds[m++] = log_bayes(p, others, i) + log_prior;
        }
        const int t = p->term[k];
        const double error = sqrt(p->covariance[k * n + k]), half = INTERVAL * error;
        shared[k] =
            (mukca_shared){.effect = mukca_fleet_term(t, f->model.n_joints),
                           .mean = p->mean[k],
                           .error = error,
                           .low = fmax(p->mean[k] - half, 0),
                           .high = p->mean[k] + half,
                           .spread = p->spread[k],
                           .arms = p->arms[k],
                           .log_bayes_factor = odds[own] - log_prior,
                           .probability = exp(odds[own] - mukca_stats_log_sum_exp(odds, m))};
    }
}
