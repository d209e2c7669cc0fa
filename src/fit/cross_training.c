/* Errors on placements that were not used for training: one fit for each choice of placements. */
#include "fit/evaluate.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/pool.h"
#include "model/dataset_subset.h"

typedef struct {
    const mukca_chain *chain;
    const mukca_dataset *data, *test;
    mukca_cross_training_fn *report;
    void *context;
    unsigned char *train, *keep; /* [n_placements], [n_rows] 1: used for training */
    mukca_score *scores, *test_scores;
    int done, total;
} run;

/* Fit to the marked placements; score all placements, and *n_test of the test data. */
static mukca_status fit_marked(int *n, int *n_test, const run *r, mukca_error *error)
{
    mukca_dataset part = {0};
    mukca_fit fit = {0};
    for (int i = 0; i < r->data->n_rows; i++) {
        const int placement = mukca_dataset_placement(r->data, i);
        r->keep[i] = placement >= 0 && r->train[placement];
    }
    mukca_status status = mukca_dataset_subset(&part, r->data, r->keep, error);
    if (status == MUKCA_OK) status = mukca_fit_run(&fit, r->chain, &part, NULL, error);
    const mukca_model model = {.chain = &fit.chain, .theta = fit.theta};
    if (status == MUKCA_OK) {
        *n = mukca_evaluate(r->scores, NULL, &model, r->data);
        *n_test = r->test->n_rows > 0 ? mukca_evaluate(r->test_scores, NULL, &model, r->test) : 0;
        if (*n < 0 || *n_test < 0) status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    }
    mukca_fit_free(&fit);
    mukca_dataset_free(&part);
    return status;
}

static void add(mukca_cross_training *result, int *count, double mae)
{
    result->mean = ++*count > 1 ? result->mean + (mae - result->mean) / *count : mae;
}

/* Train on placements a and b (which may be the same), or on `all`. */
static mukca_status train_on(run *r, int a, int b, bool all, mukca_error *error)
{
    const int n = r->data->n_placements;
    mukca_cross_training result = {.scores = r->scores, .mean = NAN};
    int count = 0, n_test;
    memset(r->train, all, (size_t)n);
    r->train[a] = r->train[b] = 1;
    mukca_status status = fit_marked(&result.n, &n_test, r, error);
    if (status != MUKCA_OK) return status;
    for (int p = 0; p < n; p++) {
        const size_t used = strlen(result.name);
        if (r->train[p])
            snprintf(result.name + used, sizeof result.name - used, "%s%s", used ? "+" : "",
                     r->data->placements[p].name);
        result.placements += r->train[p];
    }
    if (result.placements == n && n > 1) snprintf(result.name, sizeof result.name, "all");
    for (int i = 0; i < result.n; i++)
        if (r->scores[i].placement >= 0 && !r->train[r->scores[i].placement])
            add(&result, &count, r->scores[i].mae);
    for (int i = 0; i < n_test; i++) add(&result, &count, r->test_scores[i].mae);
    return r->report(r->context, &result, (double)++r->done / r->total)
               ? MUKCA_OK
               : mukca_fail(error, MUKCA_INTERRUPTED, "interrupted; nothing was written");
}

mukca_status mukca_cross_training_run(const mukca_chain *chain, const mukca_dataset *data,
                                      const mukca_dataset *test, mukca_cross_training_fn *report,
                                      void *context, mukca_error *error)
{
    const int n = data->n_placements;
    mukca_pool pool = {0};
    run r = {.chain = chain,
             .data = data,
             .test = test,
             .report = report,
             .context = context,
             .train = MUKCA_TAKE(&pool, unsigned char, n + 1),
             .keep = MUKCA_TAKE(&pool, unsigned char, data->n_rows + 1),
             .scores = MUKCA_TAKE(&pool, mukca_score, n + 1),
             .test_scores = MUKCA_TAKE(&pool, mukca_score, test->n_placements + 1),
             .total = n * (n + 1) / 2 + (n > 2)};
    mukca_status status = pool.failed ? mukca_fail(error, MUKCA_MEMORY, "out of memory") : MUKCA_OK;
    for (int a = 0; a < n && status == MUKCA_OK; a++) status = train_on(&r, a, a, false, error);
    for (int a = 0; a < n; a++)
        for (int b = a + 1; b < n && status == MUKCA_OK; b++)
            status = train_on(&r, a, b, false, error);
    if (n > 2 && status == MUKCA_OK) status = train_on(&r, 0, 0, true, error);
    mukca_pool_free(&pool);
    return status;
}
