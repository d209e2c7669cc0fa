/* How far the gap shrinks, measured on rows that took no part in the fit. */
#include "diagnose/cross_validation.h"

#include <math.h>
#include <string.h>

#include "diagnose/candidates.h"
#include "diagnose/folds.h"
#include "math/stats.h"

void mukca_cross_validation_clear(mukca_diagnosis *d)
{
    d->structure_m = d->nominal_m = d->geometry_m = d->faults_excused_m = d->explained_m = NAN;
    d->noise_floor_m = d->noise_shrink_percent = d->surprise = d->surprise_sigmas = NAN;
    d->test_nominal_m = d->test_geometry_m = d->test_explained_m = NAN;
    d->held_out = (mukca_shrink){NAN, NAN, NAN, NAN, NAN, 0, 0};
}

/* What the best of the catalogue gains on left-out rows of pure noise, percent, by the number of
 * placements: means over simulated seven-axis arms, for two over recorded postures. */
static double noise_gain(int placements)
{
    static const double gain[] = {NAN, 3, 12, 4, 1};
    return placements < (int)(sizeof gain / sizeof *gain) ? gain[placements] : (double)NAN;
}

/* The held-out file: a model of its own for the states, the fitted unknowns for the prediction. */
static mukca_status measure_test(mukca_diagnosis *d, const mukca_regression *m,
                                 const mukca_geometry *geometry_only, const mukca_dataset *test,
                                 mukca_error *error)
{
    mukca_regression t;
    mukca_recording_options options = m->recording.options;
    options.mass_factor = m->recording.n_bodies ? m->recording.mass_factor : NULL;
    mukca_status status = mukca_regression_create(&t, m->recording.chain, test, &options, error);
    if (status != MUKCA_OK) return status;
    const int rows = test->n_rows;
    double *position = MUKCA_TAKE(&t.pool, double, 3 * rows);
    double *errors = MUKCA_TAKE(&t.pool, double, rows);
    d->n_test_placements = test->n_placements;
    d->test_placement_mae_m = MUKCA_TAKE(&d->pool, double, test->n_placements + 1);
    if (t.pool.failed || d->pool.failed) goto out;
    t.unknowns.tracker = m->unknowns.tracker;
    mukca_geometry nominal;
    mukca_geometry_set(&nominal, m->recording.chain, NULL);
    const mukca_geometry *const stage[3] = {&nominal, geometry_only, &m->unknowns.geometry};
    double *const result[3] = {&d->test_nominal_m, &d->test_geometry_m, &d->test_explained_m};
    for (int s = 0; s < 3; s++) {
        t.unknowns.n_causes = 0;
        for (int c = 0; s == 2 && c < m->unknowns.n_causes; c++) {
            mukca_accepted cause = m->unknowns.cause[c];
            if (!mukca_candidate_moves_arm(&cause.candidate)) continue;
            cause.candidate.placement = cause.candidate.effect.placement =
                -1; /* what one placement had, others do not */
            if (!mukca_candidate_prepare(&cause.candidate, &t.pool, &t.recording)) goto out;
            t.unknowns.cause[t.unknowns.n_causes++] = cause;
        }
        t.unknowns.geometry = *stage[s];
        for (int row = 0; row < rows; row++)
            mukca_unknowns_predict(position + 3 * row, &t.unknowns, &t.recording, row);
        mukca_folds_errors(errors, &t, position, t.recording.keep, false);
        *result[s] = mukca_folds_mean(errors, rows);
    }
    for (int p = 0; p < test->n_placements; p++) {
        double sum = 0;
        int n = 0;
        for (int row = 0; row < rows; row++)
            if (t.recording.placement[row] == p && isfinite(errors[row])) sum += errors[row], n++;
        d->test_placement_mae_m[p] = n ? sum / n : (double)NAN;
    }
out:
    if (t.pool.failed || d->pool.failed)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for %d held-out rows", rows);
    mukca_regression_free(&t);
    return status;
}

static bool tied_to_placement(const mukca_candidate *h)
{
    return h->kind == MUKCA_CANDIDATE_EFFECT &&
           (h->effect.kind == MUKCA_EFFECT_ZERO_JUMP || h->effect.kind == MUKCA_EFFECT_BALL_SHIFT);
}

/* Which cause of the model stands behind a told one. */
static int model_cause(const mukca_regression *m, const mukca_cause *cause)
{
    for (int c = 0; c < m->unknowns.n_causes; c++) {
        const mukca_candidate *h = &m->unknowns.cause[c].candidate;
        if (mukca_candidate_class(h) != (int)cause->effect.kind ||
            h->joint != cause->effect.joint || h->placement != cause->effect.placement)
            continue;
        if (mukca_candidate_is_fault(h)
                ? cause->socket < 0 || m->recording.groups[h->fault.group].socket == cause->socket
                : mukca_candidate_effect(h).variant == cause->effect.variant)
            return c;
    }
    return -1;
}

double mukca_cross_validation_structure(mukca_regression *m)
{
    unsigned char use[MUKCA_MAX_ACCEPTED];
    mukca_folds b = {.m = m};
    mukca_folds_create(&b);
    if (m->pool.failed || mukca_folds_assign(b.fold, m, false) < 2) return NAN;
    memset(use, 1, sizeof use);
    mukca_folds_run(b.error, &b, mukca_regression_collect_own(m), use, false);
    return mukca_folds_mean(b.error, m->recording.data->n_rows);
}

/* What geometry leaves, by axis. */
static void measure_axes(double rms[3], const mukca_regression *m)
{
    double square[3] = {0, 0, 0};
    for (int g = 0; g < m->recording.n_groups; g++) {
        const mukca_group *group = &m->recording.groups[g];
        for (int i = group->start; i < group->start + group->count && group->socket >= 0; i++)
            for (int c = 0; c < 3; c++)
                square[c] += pow(m->linear.tip[3 * i + c] - m->linear.mean[g][c], 2) /
                             m->recording.n_samples;
    }
    for (int c = 0; c < 3; c++) rms[c] = sqrt(square[c]);
}

/* What the nominal geometry leaves, a fitted one with faulty rows excused (`excused`, left-out
 * errors by placement and by socket), and one fitted to all rows as recorded.  The model holds
 * nothing but faults, and is left without them. */
static void measure_geometry(mukca_diagnosis *d, mukca_folds *b, double *const excused[2])
{
    static const unsigned char none[MUKCA_MAX_ACCEPTED] = {0};
    mukca_regression *m = b->m;
    const int rows = m->recording.data->n_rows;
    const bool as_recorded = m->unknowns.n_causes > 0 || m->recording.n_samples < rows;
    const mukca_geometry fitted = m->unknowns.geometry;
    measure_axes(d->axis_rms_m, m);
    mukca_geometry_set(&m->unknowns.geometry, m->recording.chain, NULL);
    for (int row = 0; row < rows; row++)
        mukca_unknowns_predict(b->position + 3 * row, &m->unknowns, &m->recording, row);
    m->unknowns.geometry = fitted;
    mukca_folds_errors(b->error, m, b->position, b->all, false);
    d->nominal_m = mukca_folds_mean(b->error, rows);
    if (d->folds < 2) return;
    mukca_normal_equations *normal = mukca_regression_collect_own(m);
    for (int by_socket = 0; by_socket < 2; by_socket++)
        mukca_folds_run(excused[by_socket], b, normal, none, by_socket);
    d->faults_excused_m = d->geometry_m = mukca_folds_mean(excused[0], rows);
    if (!as_recorded) return;
    m->unknowns.n_causes = 0;
    memcpy(m->recording.keep, b->all, (size_t)rows);
    mukca_recording_regroup(&m->recording);
    mukca_regression_fit(m, 3, MUKCA_FIT_NOISE);
    mukca_folds_run(b->error, b, mukca_regression_collect_own(m), none, false);
    mukca_folds_errors(b->error, m, b->position, b->all, false);
    d->geometry_m = mukca_folds_mean(b->error, rows);
}

/* What all causes together leave, and each alone. */
static mukca_status measure_causes(mukca_diagnosis *d, mukca_folds *b, double *const excused[2],
                                   const mukca_diagnose_options *options, mukca_error *error)
{
    mukca_regression *m = b->m;
    const int rows = m->recording.data->n_rows;
    unsigned char use[MUKCA_MAX_ACCEPTED];
    memset(use, 1, sizeof use);
    mukca_normal_equations *normal = mukca_regression_collect_own(m);
    mukca_folds_run(b->error, b, normal, use, false);
    d->explained_m = mukca_folds_mean(b->error, rows);
    if (b->freedom > 0) {
        d->surprise = sqrt(fmax(b->surprise, 0) / b->freedom);
        d->surprise_sigmas = (b->surprise - b->freedom) / sqrt(2.0 * b->freedom);
    }
    mukca_folds_compare(&d->held_out, b, excused[0], b->error);
    for (int p = 0; p < m->recording.data->n_placements; p++) {
        double sum = 0;
        int n = 0;
        for (int row = 0; row < rows; row++)
            if (m->recording.placement[row] == p && isfinite(b->error[row]))
                sum += b->error[row], n++;
        d->placement_mae_m[p] = n ? sum / n : (double)NAN;
    }
    for (int i = 0; i < d->n_causes; i++) {
        const int c = model_cause(m, &d->causes[i]);
        if (c < 0 || !m->unknowns.cause[c].candidate.basis) continue;
        /* What belongs to a placement must have seen it: leave one socket out instead. */
        const bool by_socket = tied_to_placement(&m->unknowns.cause[c].candidate);
        if (options->progress &&
            !options->progress(options->progress_context, 0.7 + 0.2 * i / d->n_causes,
                               "measuring on held-out rows"))
            return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
        memset(use, 0, sizeof use);
        use[c] = 1;
        mukca_folds_run(b->error, b, normal, use, by_socket);
        mukca_folds_compare(&d->causes[i].held_out, b, excused[by_socket], b->error);
    }
    return MUKCA_OK;
}

mukca_status mukca_cross_validation_run(mukca_diagnosis *d, mukca_regression *m,
                                        const mukca_diagnose_options *options, mukca_error *error)
{
    const int rows = m->recording.data->n_rows;
    mukca_folds b = {.m = m};
    mukca_folds_create(&b);
    double *const excused[2] = {MUKCA_TAKE(&m->pool, double, rows),
                                MUKCA_TAKE(&m->pool, double, rows)};
    unsigned char *kept = MUKCA_TAKE(&m->pool, unsigned char, rows);
    mukca_unknowns explained;
    if (!mukca_unknowns_clone(&explained, &m->pool, &m->unknowns))
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", rows);
    d->placement_mae_m = MUKCA_TAKE(&d->pool, double, m->recording.data->n_placements + 1);
    if (m->pool.failed || d->pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", rows);
    d->folds = mukca_folds_assign(b.fold, m, false);
    d->noise_floor_m = MUKCA_MEAN_NORM3 * d->sigma_m;
    d->noise_shrink_percent = noise_gain(m->recording.data->n_placements);

    memcpy(kept, m->recording.keep, (size_t)rows);
    for (int c = 0; c < m->unknowns.n_causes; c++)
        if (!mukca_candidate_is_fault(&m->unknowns.cause[c].candidate))
            mukca_unknowns_drop(&m->unknowns, c--);
    mukca_regression_fit(m, 4, MUKCA_FIT_ALL);
    const mukca_geometry geometry_only = m->unknowns.geometry;
    measure_geometry(d, &b, excused);
    mukca_unknowns_assign(&m->unknowns, &explained);
    memcpy(m->recording.keep, kept, (size_t)rows);
    mukca_recording_regroup(&m->recording);
    mukca_regression_linearise(m);
    if (d->folds >= 2) {
        const mukca_status status = measure_causes(d, &b, excused, options, error);
        if (status != MUKCA_OK) return status;
    }
    m->unknowns.geometry = explained.geometry;
    return options->test ? measure_test(d, m, &geometry_only, options->test, error) : MUKCA_OK;
}
