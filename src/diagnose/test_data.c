/* Errors on test data, which no fit uses (--test). */
#include "diagnose/held_out.h"

#include <math.h>
#include <string.h>

/* Where the state that a cause depends on is unknown, the mean of the training is expected. */
static void take_mean(mukca_candidate *cause, int n_rows, const mukca_candidate *trained, int n)
{
    const int terms = cause->terms * cause->width_of_term;
    for (int k = 0; k < terms; k++) {
        double sum = 0;
        for (int row = 0; row < n; row++) sum += (double)trained->basis[(long)row * terms + k];
        for (int row = 0; row < n_rows; row++)
            cause->basis[(long)row * terms + k] = (float)(sum / n);
    }
}

/* Copy the causes that act on the arm, with their basis at the states of the test rows. */
static bool carry_causes(mukca_regression *t, const mukca_regression *m)
{
    const mukca_unknowns *from = &m->unknowns;
    const mukca_dataset *test = t->recording.data;
    for (int c = 0; c < from->n_causes; c++) {
        mukca_accepted cause = from->cause[c];
        if (!mukca_candidate_moves_arm(&cause.candidate)) continue;
        /* placements of the training data do not recur, and a drift needs times */
        const bool unknown =
            cause.candidate.placement >= 0 ||
            (!test->time &&
             mukca_effect_has(mukca_candidate_class(&cause.candidate), MUKCA_TRAIT_OF_TIME));
        cause.candidate.placement = -1;
        if (cause.candidate.kind == MUKCA_CANDIDATE_EFFECT) cause.candidate.effect.placement = -1;
        if (!mukca_candidate_prepare(&cause.candidate, &t->pool, &t->recording)) return false;
        if (unknown)
            take_mean(&cause.candidate, test->n_rows, &from->cause[c].candidate,
                      m->recording.data->n_rows);
        t->unknowns.cause[t->unknowns.n_causes++] = cause;
    }
    return true;
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

/* Set the target offsets of the logs from `first` on: the mean of the measurements in the tip frame
 * of the present arm. */
static void place_targets(mukca_regression *test, int first)
{
    const mukca_recording *r = &test->recording;
    mukca_unknowns *u = &test->unknowns;
    for (int log = first; log < MUKCA_MAX_LOGS; log++) {
        double sum[3] = {0};
        int n = 0;
        u->arm.log.tracker[log] = u->arm.log.tracker[0];
        for (int row = 0; row < r->data->n_rows; row++) {
            if (r->log[row] != log || r->data->socket[row] >= 0) continue;
            double measured[3], local[3];
            mukca_frame tip;
            mukca_displacement d;
            mukca_unknowns_displacement(&d, u, r->chain->n_joints, row);
            mukca_fk_pose(&tip, &u->arm.geometry,
                          r->data->q + (size_t)row * (size_t)r->chain->n_joints,
                          u->n_causes ? &d : NULL);
            mukca_unknowns_to_base(measured, u, log, r->data->position + 3 * (size_t)row);
            for (int c = 0; c < 3; c++) measured[c] -= tip.p[c];
            mukca_mat3_tvec(local, tip.R, measured);
            for (int c = 0; c < 3; c++) sum[c] += local[c];
            n++;
        }
        u->arm.log.shift[log] = (mukca_frame){.R = MUKCA_IDENTITY};
        for (int c = 0; c < 3 && n; c++) u->arm.log.shift[log].p[c] = sum[c] / n;
    }
}

/* Assign to each test log the frames of the training log of its target; without names, of the one
 * with the smallest error.  Returns the first log of a target without training data. */
static int match_logs(mukca_regression *test, const mukca_regression *training)
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

mukca_status mukca_test_data_measure(mukca_diagnosis *d, double *of_geometry,
                                     const mukca_regression *m, const mukca_arm_state *geometry,
                                     const mukca_dataset *test, mukca_error *error)
{
    /* states only, without columns: predictions use the fitted unknowns */
    mukca_pool scratch = {0};
    mukca_regression *t = MUKCA_TAKE(&scratch, mukca_regression, 1);
    mukca_arm_state *nominal = MUKCA_TAKE(&scratch, mukca_arm_state, 1);
    if (!t || !nominal) {
        mukca_pool_free(&scratch);
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the held-out rows");
    }
    mukca_recording_options options = m->recording.options;
    options.base_per_log = options.tool_per_log = false; /* frames are those of the training logs */
    options.mass_factor = m->recording.n_bodies ? m->recording.mass_factor : NULL;
    mukca_status status = MUKCA_OK;
    const int rows = test->n_rows;
    if (!mukca_recording_create(&t->recording, &t->pool, m->recording.chain, test, &options) ||
        !mukca_unknowns_create(&t->unknowns, &t->pool, &t->recording)) {
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for %d held-out rows", rows);
        goto out;
    }
    double *position = MUKCA_TAKE(&t->pool, double, 3 * rows);
    double *row_error = MUKCA_TAKE(&t->pool, double, rows);
    *nominal = mukca_unknowns_nominal_arm(&m->unknowns, m->recording.chain);
    const mukca_arm_state *const step[3] = {nominal, geometry, &m->unknowns.arm};
    double *const result[3] = {&d->test_nominal_m, &d->test_geometry_m, &d->test_explained_m};
    t->unknowns.arm = *geometry;
    const int untrained = match_logs(t, m);
    d->n_test_placements = test->n_placements;
    d->test_placement_mae_m = MUKCA_TAKE(&d->pool, double, test->n_placements + 1);
    d->before_m = MUKCA_TAKE(&d->pool, double, rows);
    d->after_m = MUKCA_TAKE(&d->pool, double, rows);
    double *const rows_of[3] = {d->before_m, of_geometry ? of_geometry : row_error, d->after_m};
    for (int s = 0; s < 3 && !t->pool.failed && !d->pool.failed; s++) {
        if (s == 2 && !carry_causes(t, m)) break;
        row_error = rows_of[s];
        t->unknowns.arm = *step[s];
        place_targets(t, untrained);
        for (int row = 0; row < rows; row++)
            mukca_unknowns_predict(position + 3 * row, &t->unknowns, &t->recording, row);
        mukca_folds_errors(row_error, t, position, t->recording.keep, false);
        *result[s] = mukca_folds_mean(row_error, rows);
    }
    if (t->pool.failed || d->pool.failed)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for %d held-out rows", rows);
    else
        mukca_folds_by_placement(d->test_placement_mae_m, &t->recording, row_error);
out:
    mukca_regression_free(t);
    mukca_pool_free(&scratch);
    return status;
}
