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
    for (int j = -1; j < m->recording.chain->n_joints; j++)
        mukca_candidates_append_effects(&all, j);
    mukca_candidates_compute(&all);
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

/* Match test logs by the names of their targets; targets without training data are numbered after
 * the training logs.  Returns the first of these. */
static int match_targets(mukca_regression *test, const mukca_regression *training)
{
    const mukca_recording *from = &training->recording;
    const mukca_dataset *known = from->data, *data = test->recording.data;
    const int first = from->n_logs;
    for (int row = 0; row < data->n_rows; row++) {
        const int t = mukca_dataset_target(data, row);
        if (data->socket[row] >= 0) continue;
        int log = t < 0 ? 0 : first + t;
        for (int k = 0; k < known->n_rows && log >= first; k++) {
            const int target = mukca_dataset_target(known, k);
            if (target >= 0 && strcmp(known->targets[target], data->targets[t]) == 0)
                log = from->log[k];
        }
        test->recording.log[row] = log < MUKCA_MAX_LOGS ? log : 0;
    }
    if (test->unknowns.n_targets < 2) test->unknowns.n_targets = 2; /* applies the shifts */
    return first;
}

void mukca_logs_place_targets(mukca_regression *test, int first)
{
    const mukca_recording *r = &test->recording;
    mukca_unknowns *u = &test->unknowns;
    for (int log = first; log < MUKCA_MAX_LOGS; log++) {
        double sum[3] = {0};
        int n = 0;
        u->log.tracker[log] = u->log.tracker[0];
        for (int row = 0; row < r->data->n_rows; row++) {
            if (r->log[row] != log || r->data->socket[row] >= 0) continue;
            double measured[3], local[3];
            mukca_frame tip;
            mukca_displacement d;
            mukca_unknowns_displacement(&d, u, r->chain->n_joints, row);
            mukca_fk_pose(&tip, &u->geometry, r->data->q + (size_t)row * (size_t)r->chain->n_joints,
                          u->n_causes ? &d : NULL);
            mukca_unknowns_to_base(measured, u, log, r->data->position + 3 * (size_t)row);
            for (int c = 0; c < 3; c++) measured[c] -= tip.p[c];
            mukca_mat3_tvec(local, tip.R, measured);
            for (int c = 0; c < 3; c++) sum[c] += local[c];
            n++;
        }
        u->log.shift[log] = (mukca_frame){.R = MUKCA_IDENTITY};
        for (int c = 0; c < 3 && n; c++) u->log.shift[log].p[c] = sum[c] / n;
    }
}

int mukca_logs_match(mukca_regression *test, const mukca_regression *training)
{
    const mukca_recording *from = &training->recording;
    mukca_recording *r = &test->recording;
    const int rows = r->data->n_rows, n = r->n_logs;
    test->unknowns.n_targets = training->unknowns.n_targets;
    if (r->data->n_targets > 0) return match_targets(test, training);
    int match[MUKCA_MAX_LOGS] = {0};
    double least[MUKCA_MAX_LOGS];
    for (int log = 0; log < n; log++) least[log] = HUGE_VAL;
    const bool per_log = from->options.base_per_log || from->options.tool_per_log;
    for (int g = 0; per_log && g < from->n_logs; g++)
        for (int log = 0; log < n; log++) {
            int count = 0;
            double sum = 0;
            for (int row = 0; row < rows; row++) {
                if (r->log[row] != log || r->data->socket[row] >= 0) continue;
                double p[3];
                r->log[row] = g;
                mukca_unknowns_predict(p, &test->unknowns, r, row);
                r->log[row] = log;
                for (int c = 0; c < 3; c++) p[c] -= r->data->position[3 * (size_t)row + (size_t)c];
                sum += sqrt(mukca_dot3(p, p)), count++;
            }
            if (count && sum / count < least[log]) least[log] = sum / count, match[log] = g;
        }
    for (int row = 0; row < rows; row++) r->log[row] = match[r->log[row]];
    return MUKCA_MAX_LOGS;
}
