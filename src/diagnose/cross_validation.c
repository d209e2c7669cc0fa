/* How far the gap shrinks, measured on rows that took no part in the fit. */
#include "diagnose/cross_validation.h"

#include <math.h>
#include <string.h>

#include "diagnose/candidates.h"
#include "diagnose/folds.h"
#include "math/stats.h"

void gap_held_out_nothing(mukca_diagnosis *d)
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
static mukca_status measure_test(mukca_diagnosis *d, const gap_model *m,
                                 const mukca_geometry *geometry_only, const mukca_dataset *test,
                                 mukca_error *error)
{
    gap_model t;
    gap_options options = m->options;
    options.lump_scale = m->n_lumps ? m->lump_scale : NULL;
    mukca_status status = gap_model_create(&t, m->chain, test, &options, error);
    if (status != MUKCA_OK) return status;
    const int rows = test->n_rows;
    double *position = MUKCA_TAKE(&t.pool, double, 3 * rows);
    double *errors = MUKCA_TAKE(&t.pool, double, rows);
    d->n_test_placements = test->n_placements;
    d->test_placement_mae_m = MUKCA_TAKE(&d->pool, double, test->n_placements + 1);
    if (t.pool.failed || d->pool.failed) goto out;
    t.tracker = m->tracker;
    mukca_geometry nominal;
    mukca_geometry_set(&nominal, m->chain, NULL);
    const mukca_geometry *const stage[3] = {&nominal, geometry_only, &m->geometry};
    double *const result[3] = {&d->test_nominal_m, &d->test_geometry_m, &d->test_explained_m};
    for (int s = 0; s < 3; s++) {
        t.n_causes = 0;
        for (int c = 0; s == 2 && c < m->n_causes; c++) {
            gap_cause cause = m->cause[c];
            if (!cause.hypothesis.basis || cause.hypothesis.kind == GAP_STRETCH) continue;
            cause.hypothesis.effect.placement = -1; /* what one placement had, others do not */
            if (!gap_hypothesis_prepare(&cause.hypothesis, &t.pool, &t)) goto out;
            t.cause[t.n_causes++] = cause;
        }
        t.geometry = *stage[s];
        for (int row = 0; row < rows; row++) gap_model_predict(position + 3 * row, &t, row);
        gap_left_out_errors(errors, &t, position, t.keep, false);
        *result[s] = gap_left_out_mean(errors, rows);
    }
    for (int p = 0; p < test->n_placements; p++) {
        double sum = 0;
        int n = 0;
        for (int row = 0; row < rows; row++)
            if (t.placement[row] == p && isfinite(errors[row])) sum += errors[row], n++;
        d->test_placement_mae_m[p] = n ? sum / n : (double)NAN;
    }
out:
    if (t.pool.failed || d->pool.failed)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for %d held-out rows", rows);
    gap_model_free(&t);
    return status;
}

static bool tied_to_placement(const gap_hypothesis *h)
{
    return h->kind == GAP_EFFECT &&
           (h->effect.kind == MUKCA_EFFECT_ZERO_JUMP || h->effect.kind == MUKCA_EFFECT_BALL_SHIFT);
}

/* Which cause of the model stands behind a told one. */
static int model_cause(const gap_model *m, const mukca_cause *cause)
{
    for (int c = 0; c < m->n_causes; c++) {
        const gap_hypothesis *h = &m->cause[c].hypothesis;
        if (h->kind == GAP_SPIKE || h->kind == GAP_BUMPS || h->kind == GAP_STRETCH) continue;
        if (h->effect.kind == cause->effect.kind && h->effect.joint == cause->effect.joint &&
            h->effect.variant == cause->effect.variant &&
            h->effect.placement == cause->effect.placement &&
            (cause->socket < 0 || m->groups[h->group].socket == cause->socket))
            return c;
    }
    return -1;
}

double gap_held_out_structure(gap_model *m)
{
    unsigned char use[GAP_MAX_CAUSES];
    gap_left_out b = {.m = m};
    gap_left_out_take(&b);
    if (m->pool.failed || gap_left_out_folds(b.fold, m, false) < 2) return NAN;
    memset(use, 1, sizeof use);
    gap_left_out_run(b.error, &b, gap_left_out_pack(m), use, false);
    return gap_left_out_mean(b.error, m->data->n_rows);
}

/* What geometry leaves, by axis. */
static void measure_axes(double rms[3], const gap_model *m)
{
    double square[3] = {0, 0, 0};
    for (int g = 0; g < m->n_groups; g++) {
        const gap_group *group = &m->groups[g];
        for (int i = group->start; i < group->start + group->count && group->socket >= 0; i++)
            for (int c = 0; c < 3; c++)
                square[c] += pow(m->tip[3 * i + c] - group->mean[c], 2) / m->n;
    }
    for (int c = 0; c < 3; c++) rms[c] = sqrt(square[c]);
}

/* What the nominal geometry leaves, a fitted one with faulty rows excused (`excused`, left-out
 * errors by placement and by socket), and one fitted to all rows as recorded.  The model holds
 * nothing but faults, and is left without them. */
static void measure_geometry(mukca_diagnosis *d, gap_left_out *b, double *const excused[2])
{
    static const unsigned char none[GAP_MAX_CAUSES] = {0};
    gap_model *m = b->m;
    const int rows = m->data->n_rows;
    const bool as_recorded = m->n_causes > 0 || m->n < rows;
    const mukca_geometry fitted = m->geometry;
    measure_axes(d->axis_rms_m, m);
    mukca_geometry_set(&m->geometry, m->chain, NULL);
    for (int row = 0; row < rows; row++) gap_model_predict(b->position + 3 * row, m, row);
    m->geometry = fitted;
    gap_left_out_errors(b->error, m, b->position, b->all, false);
    d->nominal_m = gap_left_out_mean(b->error, rows);
    if (d->folds < 2) return;
    gap_pack *pack = gap_left_out_pack(m);
    for (int by_socket = 0; by_socket < 2; by_socket++)
        gap_left_out_run(excused[by_socket], b, pack, none, by_socket);
    d->faults_excused_m = d->geometry_m = gap_left_out_mean(excused[0], rows);
    if (!as_recorded) return;
    m->n_causes = 0;
    memcpy(m->keep, b->all, (size_t)rows);
    gap_model_regroup(m);
    gap_model_fit(m, 3, GAP_NOISE);
    gap_left_out_run(b->error, b, gap_left_out_pack(m), none, false);
    gap_left_out_errors(b->error, m, b->position, b->all, false);
    d->geometry_m = gap_left_out_mean(b->error, rows);
}

/* What all causes together leave, and each alone. */
static mukca_status measure_causes(mukca_diagnosis *d, gap_left_out *b, double *const excused[2],
                                   const mukca_diagnose_options *options, mukca_error *error)
{
    gap_model *m = b->m;
    const int rows = m->data->n_rows;
    unsigned char use[GAP_MAX_CAUSES];
    memset(use, 1, sizeof use);
    gap_pack *pack = gap_left_out_pack(m);
    gap_left_out_run(b->error, b, pack, use, false);
    d->explained_m = gap_left_out_mean(b->error, rows);
    if (b->freedom > 0) {
        d->surprise = sqrt(fmax(b->surprise, 0) / b->freedom);
        d->surprise_sigmas = (b->surprise - b->freedom) / sqrt(2.0 * b->freedom);
    }
    gap_left_out_compare(&d->held_out, b, excused[0], b->error);
    for (int p = 0; p < m->data->n_placements; p++) {
        double sum = 0;
        int n = 0;
        for (int row = 0; row < rows; row++)
            if (m->placement[row] == p && isfinite(b->error[row])) sum += b->error[row], n++;
        d->placement_mae_m[p] = n ? sum / n : (double)NAN;
    }
    for (int i = 0; i < d->n_causes; i++) {
        const int c = model_cause(m, &d->causes[i]);
        if (c < 0 || !m->cause[c].hypothesis.basis) continue;
        /* What belongs to a placement must have seen it: leave one socket out instead. */
        const bool by_socket = tied_to_placement(&m->cause[c].hypothesis);
        if (options->progress &&
            !options->progress(options->progress_context, 0.7 + 0.2 * i / d->n_causes,
                               "measuring on held-out rows"))
            return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
        memset(use, 0, sizeof use);
        use[c] = 1;
        gap_left_out_run(b->error, b, pack, use, by_socket);
        gap_left_out_compare(&d->causes[i].held_out, b, excused[by_socket], b->error);
    }
    return MUKCA_OK;
}

mukca_status gap_held_out(mukca_diagnosis *d, gap_model *m, const mukca_diagnose_options *options,
                          mukca_error *error)
{
    const int rows = m->data->n_rows;
    gap_left_out b = {.m = m};
    gap_left_out_take(&b);
    double *const excused[2] = {MUKCA_TAKE(&m->pool, double, rows),
                                MUKCA_TAKE(&m->pool, double, rows)};
    unsigned char *kept = MUKCA_TAKE(&m->pool, unsigned char, rows);
    gap_cause *causes = MUKCA_TAKE(&m->pool, gap_cause, GAP_MAX_CAUSES);
    double *theta = MUKCA_TAKE(&m->pool, double, 2 * m->n_geometry);
    d->placement_mae_m = MUKCA_TAKE(&d->pool, double, m->data->n_placements + 1);
    if (m->pool.failed || d->pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", rows);
    d->folds = gap_left_out_folds(b.fold, m, false);
    d->noise_floor_m = MUKCA_MEAN_NORM3 * d->sigma_m;
    d->noise_shrink_percent = noise_gain(m->data->n_placements);

    const gap_model explained = *m;
    const size_t bytes = sizeof *theta * (size_t)m->n_geometry;
    memcpy(kept, m->keep, (size_t)rows);
    memcpy(causes, m->cause, sizeof *causes * GAP_MAX_CAUSES);
    memcpy(theta, m->theta, bytes);
    memcpy(theta + m->n_geometry, m->theta_sigma, bytes);
    m->n_causes = 0;
    for (int c = 0; c < explained.n_causes; c++)
        if (gap_left_out_fault(&causes[c].hypothesis)) m->cause[m->n_causes++] = causes[c];
    gap_model_fit(m, 4, GAP_FREE);
    const mukca_geometry geometry_only = m->geometry;
    measure_geometry(d, &b, excused);
    const mukca_pool pool = m->pool;
    *m = explained;
    m->pool = pool;
    memcpy(m->keep, kept, (size_t)rows);
    memcpy(m->cause, causes, sizeof *causes * GAP_MAX_CAUSES);
    memcpy(m->theta, theta, bytes);
    memcpy(m->theta_sigma, theta + m->n_geometry, bytes);
    gap_model_regroup(m);
    gap_model_linearise(m);
    if (d->folds >= 2) {
        const mukca_status status = measure_causes(d, &b, excused, options, error);
        if (status != MUKCA_OK) return status;
    }
    m->geometry = explained.geometry;
    return options->test ? measure_test(d, m, &geometry_only, options->test, error) : MUKCA_OK;
}
