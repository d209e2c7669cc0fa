/* How far the gap shrinks, measured on rows that took no part in the fit.
 *
 * The model is linearised once.  Leaving a fold out subtracts its part of the normal equations; the
 * unknowns that the rest gives are put into the full kinematics to predict the rows of the fold.
 */
#include "study/held_out.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "math/dense.h"
#include "math/random.h"
#include "math/stats.h"
#include "study/hypothesis.h"

enum { POSE_FOLDS = 5, DRAWS = 400 };

typedef struct {
    gap_model *m;
    int n_folds;
    int *fold;        /* [n_rows] */
    double *prior;    /* [capacity] */
    double *gram;     /* of one fold */
    double *distance; /* the pack's, kept while a fold's rows are blanked */
    double *position; /* [n_rows][3] predictions of the rows while they were left out */
    double *error;    /* [n_rows], NaN: not measured */
    double surprise;  /* squared misfit of the left-out rows in units of what it should be */
    int freedom;      /* of the left-out rows: what `surprise` would be if nothing were missing */
} bench;

void gap_held_out_nothing(mukca_diagnosis *d)
{
    d->structure_m = d->nominal_m = d->geometry_m = d->faults_excused_m = d->explained_m = NAN;
    d->noise_floor_m = d->noise_shrink_percent = d->surprise = d->surprise_sigmas = NAN;
    d->test_nominal_m = d->test_geometry_m = d->test_explained_m = NAN;
    d->held_out = (mukca_shrink){NAN, NAN, NAN, NAN, NAN, 0, 0};
}

/* Distance of each row's prediction from its socket's mean (of the rows that `of` marks), about
 * each segment or the creep line where a fault of the tool is known; or from its measurement. */
static void row_errors(double *error, const gap_model *m, const double *position,
                       const unsigned char *of, bool excuse)
{
    const mukca_dataset *data = m->data;
    double *centred = error; /* in place, row by row */
    for (int row = 0; row < data->n_rows; row++) {
        error[row] = NAN;
        if (!of[row] || data->socket[row] >= 0) continue;
        double difference[3], in_base[3];
        for (int c = 0; c < 3; c++)
            difference[c] = data->position[3 * (size_t)row + (size_t)c] - m->tracker.p[c];
        mukca_mat3_tvec(in_base, m->tracker.R, difference);
        for (int c = 0; c < 3; c++) in_base[c] -= position[3 * row + c];
        error[row] = sqrt(mukca_dot3(in_base, in_base));
    }
    for (int s = 0; s < data->n_sockets; s++) {
        const gap_hypothesis *step = NULL, *creep = NULL;
        for (int c = 0; excuse && c < m->n_causes; c++) {
            const gap_hypothesis *h = &m->cause[c].hypothesis;
            if (m->groups[h->group].socket != s) continue;
            if (h->kind == GAP_STEP) step = h;
            if (h->kind == GAP_CREEP) creep = h;
        }
        for (int part = 0; part < (step ? 2 : 1); part++) {
            double n = 0, mean[3] = {0}, share_mean = 0, slope[3] = {0}, share2 = 0;
            for (int pass = 0; pass < 3; pass++)
                for (int row = 0; row < data->n_rows; row++) {
                    if (!of[row] || data->socket[row] != s) continue;
                    if (step && (row >= step->row) != part) continue;
                    const double *x = position + 3 * row;
                    if (pass == 0) {
                        const double before = n++;
                        for (int c = 0; c < 3; c++) mean[c] = (mean[c] * before + x[c]) / n;
                        share_mean = (share_mean * before + row) / n;
                    } else if (pass == 1) {
                        const double t = row - share_mean;
                        share2 += t * t;
                        for (int c = 0; c < 3; c++) slope[c] += t * (x[c] - mean[c]);
                    } else {
                        double e[3];
                        const double t = creep && share2 > 0 ? (row - share_mean) / share2 : 0;
                        for (int c = 0; c < 3; c++) e[c] = x[c] - mean[c] - t * slope[c];
                        centred[row] = sqrt(mukca_dot3(e, e));
                    }
                }
        }
    }
}

static double mean_error(const double *error, int n, int *used)
{
    double sum = 0;
    int count = 0;
    for (int i = 0; i < n; i++)
        if (isfinite(error[i])) sum += error[i], count++;
    if (used) *used = count;
    return count ? sum / count : (double)NAN;
}

/* Prior sigmas with only the causes that `use` marks (and the faults of the tool). */
static void priors_of(bench *b, const unsigned char *use)
{
    const gap_model *m = b->m;
    gap_model_prior(b->prior, m, -1);
    int column = m->n_geometry;
    for (int c = 0; c < m->n_causes; c++) {
        const gap_hypothesis *h = &m->cause[c].hypothesis;
        const bool fault = h->kind == GAP_STEP || h->kind == GAP_CREEP || h->kind == GAP_SPIKE;
        for (int t = 0; t < h->terms; t++, column++)
            if (!fault && !use[c]) b->prior[column] = 0;
    }
}

/* Fit without each fold in turn and predict it; the model must be linearised, `pack` filled.
 *
 * With Gaussians, -2 log p(fold | rest) has the quadratic part Q(all) - Q(rest): the fold's squared
 * misfit with noise and with what the rest leaves open, all correlations of its rows included. */
static void cross_predict(bench *b, gap_pack *pack, const unsigned char *use)
{
    gap_model *m = b->m;
    const int size = m->n_columns + 1, d = m->dim;
    double *mean = m->mean;
    double *theta = MUKCA_TAKE(&m->pool, double, m->n_geometry);
    gap_cause *causes = MUKCA_TAKE(&m->pool, gap_cause, GAP_MAX_CAUSES);
    if (!theta || !causes) return;
    const mukca_geometry geometry = m->geometry;
    const mukca_frame tracker = m->tracker;
    memcpy(theta, m->theta, sizeof *theta * (size_t)m->n_geometry);
    memcpy(causes, m->cause, sizeof *causes * (size_t)m->n_causes);
    memcpy(b->distance, pack->distance, sizeof *b->distance * (size_t)(m->n_pairs * size));
    priors_of(b, use);
    b->surprise = 0, b->freedom = 0;
    const bool whole = gap_model_evidence(m, pack, b->prior, m->sigma, NULL) > -HUGE_VAL;
    const double quadratic = m->quadratic;
    for (int f = 0; f < b->n_folds; f++) {
        memset(b->gram, 0, sizeof *b->gram * (size_t)(size * size));
        for (int i = 0; i < m->n; i++)
            if (b->fold[m->order[i]] == f) {
                int count = 1;
                while (i + count < m->n && b->fold[m->order[i + count]] == f) count++;
                mukca_dense_syrk(b->gram, size, pack->white + (size_t)(i * d) * (size_t)size,
                                 count * d, size);
                i += count;
            }
        for (int i = 0; i < size * size; i++) pack->gram[i] -= b->gram[i];
        for (int p = 0; p < m->n_pairs; p++) {
            const int a = m->order[m->groups[m->pairs[p].a].start],
                      c = m->order[m->groups[m->pairs[p].b].start];
            if (b->fold[a] == f || b->fold[c] == f)
                memset(pack->distance + p * size, 0, sizeof *b->distance * (size_t)size);
        }
        if (gap_model_evidence(m, pack, b->prior, m->sigma, mean) > -HUGE_VAL) {
            if (whole) b->surprise += quadratic - m->quadratic;
            for (int g = 0; whole && g < m->n_groups; g++)
                for (int i = 0; i < m->groups[g].count; i++)
                    if (b->fold[m->order[m->groups[g].start + i]] == f)
                        b->freedom += m->groups[g].socket < 0 ? d : i > 0 ? d : 0;
            memcpy(m->theta, mean, sizeof *mean * (size_t)m->n_geometry);
            int column = m->n_geometry;
            for (int c = 0; c < m->n_causes; c++)
                for (int t = 0; t < m->cause[c].hypothesis.terms; t++)
                    m->cause[c].coefficient[t] = mean[column++];
            gap_model_set_geometry(m);
            for (int row = 0; row < m->data->n_rows; row++)
                if (b->fold[row] == f) gap_model_predict(b->position + 3 * row, m, row);
        }
        memcpy(m->theta, theta, sizeof *theta * (size_t)m->n_geometry);
        memcpy(m->cause, causes, sizeof *causes * (size_t)m->n_causes);
        m->geometry = geometry;
        m->tracker = tracker;
        for (int i = 0; i < size * size; i++) pack->gram[i] += b->gram[i];
        memcpy(pack->distance, b->distance, sizeof *b->distance * (size_t)(m->n_pairs * size));
    }
}

/* What the best of the catalogue gains on left-out rows of pure noise, percent, by the number of
 * placements: means over simulated seven-axis arms, for two over recorded postures. */
static double noise_gain(int placements)
{
    static const double gain[] = {NAN, 3, 12, 4, 1};
    return placements < (int)(sizeof gain / sizeof *gain) ? gain[placements] : (double)NAN;
}

/* Interval of the shrink by resampling sockets and, within them, rows. */
static void bootstrap(mukca_shrink *shrink, const mukca_dataset *data, const double *before,
                      const double *after)
{
    double draw[DRAWS];
    int groups = data->n_sockets, *start = calloc((size_t)groups + 2, sizeof *start);
    int *rows = calloc((size_t)data->n_rows + 1, sizeof *rows), n = 0;
    mukca_random random;
    mukca_random_seed(&random, 20240917);
    if (!start || !rows) goto out;
    const bool poses = groups == 0;
    if (poses) groups = 1;
    for (int s = 0; s < groups; s++) {
        start[s] = n;
        for (int row = 0; row < data->n_rows; row++)
            if (data->socket[row] == (poses ? -1 : s) && isfinite(before[row]) &&
                isfinite(after[row]))
                rows[n++] = row;
    }
    start[groups] = n;
    for (int k = 0; n && k < DRAWS; k++) {
        double sum[2] = {0, 0};
        for (int s = 0; s < groups; s++) {
            const int pick = mukca_random_below(&random, groups);
            const int count = start[pick + 1] - start[pick];
            for (int i = 0; i < count; i++) {
                const int row = rows[start[pick] + mukca_random_below(&random, count)];
                sum[0] += before[row], sum[1] += after[row];
            }
        }
        draw[k] = sum[0] > 0 ? 100 * (1 - sum[1] / sum[0]) : 0;
    }
    if (n) {
        shrink->low_percent = mukca_stats_quantile(draw, DRAWS, 0.025);
        shrink->high_percent = mukca_stats_quantile(draw, DRAWS, 0.975);
    }
out:
    free(start);
    free(rows);
}

static void compare(mukca_shrink *shrink, const bench *b, const double *before, const double *after)
{
    const mukca_dataset *data = b->m->data;
    shrink->before_m = mean_error(before, data->n_rows, NULL);
    shrink->after_m = mean_error(after, data->n_rows, NULL);
    shrink->shrink_percent = 100 * (1 - shrink->after_m / shrink->before_m);
    shrink->folds = shrink->folds_better = 0;
    for (int f = 0; f < b->n_folds; f++) {
        double sum[2] = {0, 0};
        int n = 0;
        for (int row = 0; row < data->n_rows; row++)
            if (b->fold[row] == f && isfinite(before[row]) && isfinite(after[row]))
                sum[0] += before[row], sum[1] += after[row], n++;
        if (!n) continue;
        shrink->folds++;
        shrink->folds_better += sum[1] < sum[0];
    }
    bootstrap(shrink, data, before, after);
}

/* Folds: placements, else sockets, else blocks of a pose log. */
static int make_folds(int *fold, const gap_model *m, bool by_socket)
{
    const mukca_dataset *data = m->data;
    int n = 0, poses = 0;
    for (int row = 0; row < data->n_rows; row++) poses += data->socket[row] < 0;
    const bool sockets = by_socket || data->n_placements < 2;
    n = sockets ? data->n_sockets : data->n_placements;
    for (int row = 0, i = 0; row < data->n_rows; row++) {
        if (data->socket[row] < 0)
            fold[row] = n + (int)((long long)POSE_FOLDS * i++ / poses);
        else
            fold[row] = sockets ? data->socket[row] : m->placement[row];
    }
    return n + (poses >= POSE_FOLDS ? POSE_FOLDS : 0);
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
        row_errors(errors, &t, position, t.keep, false);
        *result[s] = mean_error(errors, rows, NULL);
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

static void bench_take(bench *b)
{
    gap_model *m = b->m;
    const int rows = m->data->n_rows;
    b->fold = MUKCA_TAKE(&m->pool, int, rows);
    b->prior = MUKCA_TAKE(&m->pool, double, m->capacity);
    b->gram = MUKCA_TAKE(&m->pool, double, (m->capacity + 1) * (m->capacity + 1));
    b->distance = MUKCA_TAKE(&m->pool, double, (m->data->n_distances + 1) * (m->capacity + 1));
    b->position = MUKCA_TAKE(&m->pool, double, 3 * rows);
    b->error = MUKCA_TAKE(&m->pool, double, rows);
}

/* Normal equations at the model's own AR(1) coefficient. */
static gap_pack *present_pack(gap_model *m)
{
    gap_pack *pack = &m->pack[0];
    for (int i = 0; i < GAP_RHOS; i++)
        if (gap_rho[i] == m->rho) pack = &m->pack[i];
    gap_model_pack(pack, m, m->rho);
    return pack;
}

double gap_held_out_structure(gap_model *m)
{
    unsigned char use[GAP_MAX_CAUSES];
    bench b = {.m = m};
    bench_take(&b);
    if (m->pool.failed) return NAN;
    b.n_folds = make_folds(b.fold, m, false);
    if (b.n_folds < 2) return NAN;
    memset(use, 1, sizeof use);
    cross_predict(&b, present_pack(m), use);
    row_errors(b.error, m, b.position, m->keep, true);
    return mean_error(b.error, m->data->n_rows, NULL);
}

mukca_status gap_held_out(mukca_diagnosis *d, gap_model *m, const mukca_diagnose_options *options,
                          mukca_error *error)
{
    const int rows = m->data->n_rows;
    unsigned char use[GAP_MAX_CAUSES], *all = MUKCA_TAKE(&m->pool, unsigned char, rows);
    bench b = {.m = m};
    mukca_geometry nominal;
    bench_take(&b);
    double *excused = MUKCA_TAKE(&m->pool, double, rows);
    unsigned char *kept = MUKCA_TAKE(&m->pool, unsigned char, rows);
    gap_cause *causes = MUKCA_TAKE(&m->pool, gap_cause, GAP_MAX_CAUSES);
    double *theta = MUKCA_TAKE(&m->pool, double, m->n_geometry);
    d->placement_mae_m = MUKCA_TAKE(&d->pool, double, m->data->n_placements + 1);
    if (m->pool.failed || d->pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", rows);
    b.n_folds = d->folds = make_folds(b.fold, m, false);
    d->noise_floor_m = MUKCA_MEAN_NORM3 * d->sigma_m;
    d->noise_shrink_percent = noise_gain(m->data->n_placements);
    memset(all, 1, (size_t)rows);
    memcpy(kept, m->keep, (size_t)rows);

    gap_pack *pack = present_pack(m);
    /* Faults excused, explained, and each cause alone: on the kept rows. */
    if (b.n_folds >= 2) {
        memset(use, 0, sizeof use);
        cross_predict(&b, pack, use);
        row_errors(excused, m, b.position, kept, true);
        d->faults_excused_m = mean_error(excused, rows, NULL);
        memset(use, 1, sizeof use);
        cross_predict(&b, pack, use);
        row_errors(b.error, m, b.position, kept, true);
        d->explained_m = mean_error(b.error, rows, NULL);
        if (b.freedom > 0) {
            d->surprise = sqrt(fmax(b.surprise, 0) / b.freedom);
            d->surprise_sigmas = (b.surprise - b.freedom) / sqrt(2.0 * b.freedom);
        }
        compare(&d->held_out, &b, excused, b.error);
        for (int p = 0; p < m->data->n_placements; p++) {
            double sum = 0;
            int n = 0;
            for (int row = 0; row < rows; row++)
                if (m->placement[row] == p && isfinite(b.error[row])) sum += b.error[row], n++;
            d->placement_mae_m[p] = n ? sum / n : (double)NAN;
        }
        for (int i = 0; i < d->n_causes; i++) {
            const int c = model_cause(m, &d->causes[i]);
            if (c < 0 || !m->cause[c].hypothesis.basis) continue;
            const bool tied = tied_to_placement(&m->cause[c].hypothesis);
            if (options->progress &&
                !options->progress(options->progress_context, 0.7 + 0.2 * i / d->n_causes,
                                   "measuring on held-out rows"))
                return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
            double *before = excused;
            if (tied) { /* its placement must be seen: leave one socket out instead */
                b.n_folds = make_folds(b.fold, m, true);
                memset(use, 0, sizeof use);
                cross_predict(&b, pack, use);
                before = MUKCA_TAKE(&m->pool, double, rows);
                if (!before) break;
                row_errors(before, m, b.position, kept, true);
            }
            memset(use, 0, sizeof use);
            use[c] = 1;
            cross_predict(&b, pack, use);
            row_errors(b.error, m, b.position, kept, true);
            compare(&d->causes[i].held_out, &b, before, b.error);
            if (tied) b.n_folds = make_folds(b.fold, m, false);
        }
    }

    /* Geometry alone on the kept rows (for the held-out file), then on all rows as recorded. */
    const double sigma = m->sigma, rho = m->rho, length = m->sigma_length, angle = m->sigma_angle;
    const mukca_geometry explained = m->geometry;
    const mukca_frame tracker = m->tracker;
    const int n_causes = m->n_causes;
    memcpy(causes, m->cause, sizeof *causes * GAP_MAX_CAUSES);
    memcpy(theta, m->theta, sizeof *theta * (size_t)m->n_geometry);
    m->n_causes = 0;
    gap_model_fit(m, 4, GAP_FREE);
    const mukca_geometry geometry_only = m->geometry;
    for (int row = 0; row < rows; row++) gap_model_predict(b.position + 3 * row, m, row);
    double axis[3] = {0, 0, 0};
    for (int i = 0; i < m->n; i++) { /* what geometry leaves, by axis */
        const gap_group *g = NULL;
        for (int k = 0; k < m->n_groups; k++)
            if (i >= m->groups[k].start && i < m->groups[k].start + m->groups[k].count)
                g = &m->groups[k];
        if (!g || g->socket < 0) continue;
        for (int c = 0; c < 3; c++) {
            double mean = 0;
            for (int k = g->start; k < g->start + g->count; k++)
                mean += m->tip[3 * k + c] / g->count;
            axis[c] += (m->tip[3 * i + c] - mean) * (m->tip[3 * i + c] - mean) / m->n;
        }
    }
    for (int c = 0; c < 3; c++) d->axis_rms_m[c] = sqrt(axis[c]);
    mukca_geometry_set(&nominal, m->chain, NULL);
    m->geometry = nominal;
    for (int row = 0; row < rows; row++) gap_model_predict(b.position + 3 * row, m, row);
    row_errors(b.error, m, b.position, all, false);
    d->nominal_m = mean_error(b.error, rows, NULL);
    if (b.n_folds >= 2) {
        memset(m->keep, 1, (size_t)rows);
        gap_model_regroup(m);
        gap_model_fit(m, 3, GAP_NOISE);
        gap_model_pack(&m->pack[0], m, m->rho);
        cross_predict(&b, &m->pack[0], use);
        row_errors(b.error, m, b.position, all, false);
        d->geometry_m = mean_error(b.error, rows, NULL);
        memcpy(m->keep, kept, (size_t)rows);
        gap_model_regroup(m);
    }
    memcpy(m->cause, causes, sizeof *causes * GAP_MAX_CAUSES);
    memcpy(m->theta, theta, sizeof *theta * (size_t)m->n_geometry);
    m->n_causes = n_causes;
    m->sigma = sigma, m->rho = rho, m->sigma_length = length, m->sigma_angle = angle;
    m->geometry = explained;
    m->tracker = tracker;
    return options->test ? measure_test(d, m, &geometry_only, options->test, error) : MUKCA_OK;
}
