/* Coefficients shared by a fleet, and their sizes: model averaging over the sets of nonzero
 * coefficients. */
#include <math.h>
#include <string.h>

#include "fleet/population.h"
#include "infer/sets.h"
#include "math/dense.h"

enum {
    T = MUKCA_FLEET_TERMS,
    BUDGET = 20,      /* sets that are expanded */
    FREEDOM = 1 << 30 /* so many degrees of freedom: the noise is known */
};

/* Of a set: negligible in a sum, and far from underflow. */
#define LEAST_LOG_WEIGHT (-200.0)

typedef struct {
    mukca_population *p;
    double total;                              /* weight of all sets so far */
    double mean[T], square[T * T], present[T]; /* sums with their weights */
} average;

/* The means as items of one column, with information E'E.  False: no memory, or E does not exist.
 */
static bool ask(mukca_question *q, mukca_pool *pool, const mukca_population *p)
{
    const int n = p->n, stride = (n + 7) & ~7;
    const double each = log(0.25);
    mukca_item *item = MUKCA_TAKE(pool, mukca_item, n + 1);
    double *E = MUKCA_TAKE(pool, double, n *stride + 1), L[T * T];
    memcpy(L, p->information, sizeof *L * (size_t)(n * n));
    if (pool->failed || mukca_dense_cholesky(L, n)) return false;
    for (int k = 0; k < n; k++) {
        /* the sizes of mukca_sizes_spring; odds of any coefficient, then of which */
        item[k] = (mukca_item){.at = k,
                               .terms = 1,
                               .prior = {.n_sizes = 4,
                                         .size = {10e-6, 30e-6, 100e-6, 300e-6},
                                         .log_weight = {each, each, each, each},
                                         .nonnegative = true},
                               .log_prior = -log(2.0 * n),
                               .key = k};
        for (int r = 0; r <= k; r++) E[r * stride + k] = L[k * n + r];
    }
    *q = (mukca_question){.n_items = n,
                          .n_columns = n,
                          .stride = stride,
                          .n_rows = n,
                          .dof = FREEDOM,
                          .residual = FREEDOM,
                          .item = item,
                          .E = E,
                          .g = p->vector};
    return true;
}

/* Add a set with its weight to the average: its coefficients are Gaussian, the others zero. */
static void take(average *a, const mukca_set *set, double log_weight)
{
    const mukca_population *p = a->p;
    const int n = p->n, m = set->n;
    const unsigned short *index = set->item;
    double A[T * T] = {0}, C[T * T] = {0}, mean[T] = {0};
    /* the lower bound preserves the value of a coefficient that is almost certainly 0 */
    const double weight = exp(fmax(log_weight, LEAST_LOG_WEIGHT));
    for (int i = 0; i < m; i++) {
        C[i * m + i] = 1, mean[i] = p->vector[index[i]];
        for (int j = 0; j <= i; j++) A[i * m + j] = p->information[index[i] * n + index[j]];
    }
    if (m && mukca_dense_cholesky(A, m)) return;
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

/* Evaluate the most probable set with each coefficient added or dropped. */
static void flip(mukca_sets *sets, mukca_population *p)
{
    const mukca_set best = sets->set[sets->best];
    for (int k = 0; k < p->n; k++) {
        int item[T], n = 0, at = 0;
        bool present = false;
        for (int i = 0; i < p->n; i++) {
            const bool member = at < best.n && best.item[at] == i;
            at += member;
            if (i == k) present = member;
            if (member != (i == k)) item[n++] = i;
        }
        const int other = mukca_sets_insert(sets, item, NULL, n);
        const double gain = other < 0 ? 0 : sets->set[other].value - best.value;
        p->log_bayes_factor[k] = (present ? -gain : gain) - sets->question->item[k].log_prior;
    }
}

bool mukca_population_average(mukca_population *p)
{
    const int n = p->n;
    if (n == 0) return true;
    mukca_pool pool = {0};
    mukca_question question;
    mukca_sets sets;
    average a = {.p = p};
    const bool ok = ask(&question, &pool, p) && mukca_sets_create(&sets, &pool, &question);
    if (ok) {
        mukca_sets_explore(&sets, BUDGET, true);
        flip(&sets, p);
        const double most = sets.set[sets.best].value;
        for (int i = 0; i < sets.n_sets; i++) take(&a, &sets.set[i], sets.set[i].value - most);
    }
    for (int i = 0; i < n && ok; i++) {
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
    const bool failed = pool.failed;
    mukca_pool_free(&pool);
    return !failed;
}
