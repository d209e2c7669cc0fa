/* Coefficients shared by a fleet, and their sizes: model averaging over the sets of nonzero
 * coefficients. */
#include <math.h>
#include <string.h>

#include "fleet/population.h"
#include "math/dense.h"
#include "math/stats.h"

enum { T = MUKCA_FLEET_TERMS };

/* Prior sigmas of a mean, rad/(N m): the sizes of mukca_sizes_spring. */
static const double sizes[] = {10e-6, 30e-6, 100e-6, 300e-6};
enum { SIZES = sizeof sizes / sizeof *sizes };

/* Of a set: negligible in a sum, and far from underflow. */
#define LEAST_LOG_WEIGHT (-200.0)

typedef struct {
    mukca_population *p;
    double log_prior; /* odds of one more coefficient: of any, then of which */
    bool set[T];      /* the most probable coefficients */
    bool best[T];     /* the best set so far, and its log odds */
    double gain;
    double total;                              /* weight of all sets so far */
    double mean[T], square[T * T], present[T]; /* sums with their weights */
} average;

/* The members of a set, without coefficient k (-1: none); A gets the factor of their information.
 * Returns their number, -1: not positive definite. */
static int factor(double *A, int *index, const average *a, const bool *set, int k)
{
    const mukca_population *p = a->p;
    int m = 0;
    for (int i = 0; i < p->n; i++)
        if (set[i] && i != k) index[m++] = i;
    for (int i = 0; i < m; i++) {
        for (int j = 0; j <= i; j++) A[i * m + j] = p->information[index[i] * p->n + index[j]];
    }
    return m && mukca_dense_cholesky(A, m) ? -1 : m;
}

/* Log Bayes factor of coefficient k, given those of the set without k. */
static double log_bayes(const average *a, const bool *set, int k)
{
    const mukca_population *p = a->p;
    int index[T] = {0};
    double A[T * T] = {0}, b[2 * T], value[SIZES];
    const int m = factor(A, index, a, set, k);
    if (m < 0) return -HUGE_VAL;
    for (int i = 0; i < m; i++)
        b[2 * i] = p->information[index[i] * p->n + k], b[2 * i + 1] = p->vector[index[i]];
    double G = p->information[k * p->n + k], g = p->vector[k];
    mukca_dense_forward(b, 2, A, m);
    for (int i = 0; i < m; i++) {
        G -= b[2 * i] * b[2 * i];
        g -= b[2 * i] * b[2 * i + 1];
    }
    for (int s = 0; s < SIZES; s++) {
        const double s2 = sizes[s] * sizes[s], d = 1 + s2 * G;
        /* half-normal prior: only one sign is possible */
        value[s] = -0.5 * log(d) + 0.5 * s2 * g * g / d + log(2) +
                   mukca_stats_log_normal_cdf(sqrt(s2 / d) * g) - log(SIZES);
    }
    return mukca_stats_log_sum_exp(value, SIZES);
}

/* Add a set with its weight to the average: its coefficients are Gaussian, the others zero. */
static void take(average *a, const bool *set, double log_weight)
{
    const int n = a->p->n;
    int index[T] = {0};
    double A[T * T] = {0}, C[T * T] = {0}, mean[T] = {0};
    /* the lower bound preserves the value of a coefficient that is almost certainly 0 */
    const double weight = exp(fmax(log_weight, LEAST_LOG_WEIGHT));
    const int m = factor(A, index, a, set, -1);
    if (m < 0) return;
    for (int i = 0; i < m; i++) C[i * m + i] = 1, mean[i] = a->p->vector[index[i]];
    mukca_dense_forward(mean, 1, A, m);
    mukca_dense_backward(mean, 1, A, m);
    mukca_dense_forward(C, m, A, m);
    mukca_dense_backward(C, m, A, m);
    a->total += weight;
    for (int i = 0; i < m; i++) {
        a->mean[index[i]] += weight * mean[i];
        a->present[index[i]] += weight;
        for (int j = 0; j < m; j++)
            a->square[index[i] * n + index[j]] += weight * (C[i * m + j] + mean[i] * mean[j]);
    }
}

/* Call f with all sets that differ from the present one by one coefficient or by one exchange, and
 * their log odds against it. */
static void visit(average *a, void (*f)(average *, const bool *set, double log_odds))
{
    const int n = a->p->n;
    bool set[T];
    memcpy(set, a->set, sizeof set);
    for (int k = 0; k < n; k++) {
        const double own = a->p->log_bayes_factor[k] = log_bayes(a, a->set, k);
        set[k] = !a->set[k];
        f(a, set, a->set[k] ? -own - a->log_prior : own + a->log_prior);
        for (int i = 0; i < n && a->set[k]; i++) {
            if (a->set[i]) continue;
            set[i] = true;
            f(a, set, log_bayes(a, set, i) - own);
            set[i] = false;
        }
        set[k] = a->set[k];
    }
}

static void remember(average *a, const bool *set, double log_odds)
{
    if (!(log_odds > a->gain)) return;
    a->gain = log_odds;
    memcpy(a->best, set, sizeof a->best);
}

/* Search for the most probable set by such steps. */
static void search(average *a)
{
    /* far more rounds than changes of coefficients */
    for (int round = 0; round < 4 * a->p->n; round++) {
        a->gain = 1e-9; /* no cycles due to rounding */
        visit(a, remember);
        if (!(a->gain > 1e-9)) return;
        memcpy(a->set, a->best, sizeof a->set);
    }
}

void mukca_population_average(mukca_population *p)
{
    const int n = p->n;
    average a = {.p = p, .log_prior = -log(2.0 * n)};
    search(&a);
    take(&a, a.set, 0);
    visit(&a, take);
    for (int i = 0; i < n; i++) {
        const double present = a.present[i], value = a.mean[i] / present;
        const double half =
            MUKCA_FLEET_INTERVAL * sqrt(fmax(a.square[i * n + i] / present - value * value, 0));
        p->probability[i] = present / a.total;
        p->value[i] = fmax(value, 0);
        p->low[i] = fmax(value - half, 0), p->high[i] = fmax(value + half, 0);
        p->average[i] = fmax(a.mean[i] / a.total, 0);
        for (int j = 0; j < n; j++)
            p->average_covariance[i * n + j] =
                (a.square[i * n + j] - a.mean[i] * a.mean[j] / a.total) / a.total;
    }
}
