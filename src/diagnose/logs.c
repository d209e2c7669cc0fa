/* Pose logs diagnosed together: which of their frames are per log. */
#include "diagnose/logs.h"

#include <math.h>
#include <string.h>

#include "diagnose/candidates.h"

/* Do the loads differ between samples? */
static bool loads_differ(const mukca_dataset *data)
{
    for (int row = 1; data->payload && row < data->n_rows; row++)
        if (fabs(data->payload[row] - data->payload[0]) > 0) return true;
    return false;
}

/* Add the springs of every loaded joint and of the base. */
static mukca_status add_springs(mukca_regression *m, mukca_error *error)
{
    unsigned char others[MUKCA_EFFECT_COUNT];
    mukca_candidates all;
    memset(others, 1, sizeof others);
    others[mukca_effect_at(MUKCA_SITE_ANGLE, MUKCA_TRAIT_FLEXIBLE)] = 0;
    others[mukca_effect_at(MUKCA_SITE_BASE, MUKCA_TRAIT_FLEXIBLE)] = 0;
    mukca_candidates_start(&all, &m->pool, &m->recording, others);
    mukca_candidates_fill(&all, NULL);
    if (m->pool.failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the logs");
    for (int i = 0; i < all.count; i++) mukca_unknowns_add(&m->unknowns, &all.list[i]);
    return MUKCA_OK;
}

/* Log evidence of one case. */
static mukca_status weigh_case(double *log_evidence, const mukca_recording_options *options,
                               const mukca_chain *chain, const mukca_dataset *data,
                               mukca_error *error)
{
    mukca_pool pool = {0};
    mukca_regression *m = MUKCA_TAKE(&pool, mukca_regression, 1);
    if (!m) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the logs");
    mukca_status status = mukca_regression_create(m, chain, data, options, error);
    if (status == MUKCA_OK) mukca_regression_fit(m, 6, MUKCA_FIT_ALL);
    if (status == MUKCA_OK && loads_differ(data)) {
        status = add_springs(m, error);
        if (status == MUKCA_OK) mukca_regression_fit(m, 6, MUKCA_FIT_ALL);
    }
    if (status == MUKCA_OK) *log_evidence = mukca_regression_factor(m);
    mukca_regression_free(m);
    mukca_pool_free(&pool);
    return status;
}

mukca_status mukca_logs_compare(mukca_logs *logs, mukca_recording_options *options,
                                const mukca_chain *chain, const mukca_dataset *data,
                                mukca_error *error)
{
    const mukca_recording_options given = *options;
    double best = -HUGE_VAL;
    *logs = (mukca_logs){.n = mukca_recording_number_logs(NULL, data)};
    if (logs->n < 2) return MUKCA_OK;
    if (data->n_targets > 1) { /* each has its own position on the tool; one tracker for all */
        for (int i = 0; i < 4; i++) logs->log_evidence[i] = NAN;
        options->base_per_log = false;
        logs->tool_per_log = options->tool_per_log = given.free_tool;
        return MUKCA_OK;
    }
    for (int i = 0; i < 4; i++) {
        mukca_recording_options tried = given;
        logs->log_evidence[i] = NAN;
        tried.base_per_log = i & 1, tried.tool_per_log = i & 2;
        if ((tried.base_per_log && !given.free_base) || (tried.tool_per_log && !given.free_tool))
            continue;
        MUKCA_TRY(weigh_case(&logs->log_evidence[i], &tried, chain, data, error));
        if (!(logs->log_evidence[i] > best)) continue;
        best = logs->log_evidence[i];
        *options = tried;
    }
    logs->base_per_log = options->base_per_log;
    logs->tool_per_log = options->tool_per_log;
    return MUKCA_OK;
}
