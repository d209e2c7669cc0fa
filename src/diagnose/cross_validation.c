/* Held-out errors: how far the error shrinks on samples that took no part in the fit. */
#include "diagnose/cross_validation.h"

#include <math.h>
#include <string.h>

#include "diagnose/folds.h"

void mukca_cross_validation_clear(mukca_validation *v)
{
    *v = (mukca_validation){.nominal_m = NAN,
                            .geometry_m = NAN,
                            .faults_excused_m = NAN,
                            .explained_m = NAN,
                            .surprise = NAN,
                            .surprise_sigmas = NAN,
                            .shrink = MUKCA_SHRINK_NONE,
                            .noise_shrink_percent = NAN};
    for (int c = 0; c < MUKCA_MAX_CAUSES; c++) v->cause[c] = MUKCA_SHRINK_NONE;
}

/* What the best of the catalogue gains on left-out rows of pure noise, percent, by the number of
 * placements: means over simulated seven-axis arms, for two over recorded postures. */
static double noise_gain(int placements)
{
    static const double gain[] = {NAN, 3, 12, 4, 1};
    return placements < (int)(sizeof gain / sizeof *gain) ? gain[placements] : (double)NAN;
}

/* Does an effect belong to one placement, which must have been seen to predict it? */
static bool of_placement(const mukca_effect *effect)
{
    return mukca_effect_has((int)effect->kind, MUKCA_TRAIT_PER_PLACEMENT) &&
           !mukca_effect_has((int)effect->kind, MUKCA_TRAIT_RECORDING_FAULT);
}

/* The accepted cause behind a described one, -1: none. */
static int find_accepted(const mukca_regression *m, const mukca_cause *cause)
{
    for (int c = 0; c < m->unknowns.n_causes; c++) {
        const mukca_candidate *h = &m->unknowns.cause[c].candidate;
        if (mukca_candidate_class(h) >= MUKCA_EFFECT_COUNT) continue;
        const mukca_effect effect = mukca_candidate_effect(h);
        if (mukca_effect_same(&effect, &cause->effect) &&
            (cause->socket < 0 || m->recording.groups[h->fault.group].socket == cause->socket))
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
 * errors by placement and by socket), and one fitted to all rows as recorded.  The regression has
 * only faults, and is left without them. */
static void measure_geometry(mukca_validation *v, mukca_folds *b, double *const excused[2])
{
    static const unsigned char none[MUKCA_MAX_ACCEPTED] = {0};
    mukca_regression *m = b->m;
    const int rows = m->recording.data->n_rows;
    const bool as_recorded = m->unknowns.n_causes > 0 || m->recording.n_samples < rows;
    v->geometry = m->unknowns.geometry;
    measure_axes(v->axis_rms_m, m);
    mukca_geometry_set(&m->unknowns.geometry, m->recording.chain, NULL);
    for (int row = 0; row < rows; row++)
        mukca_unknowns_predict(b->position + 3 * row, &m->unknowns, &m->recording, row);
    m->unknowns.geometry = v->geometry;
    mukca_folds_errors(b->error, m, b->position, b->all, false);
    v->nominal_m = mukca_folds_mean(b->error, rows);
    if (v->folds < 2) return;
    mukca_normal_equations *normal = mukca_regression_collect_own(m);
    for (int by_socket = 0; by_socket < 2; by_socket++)
        mukca_folds_run(excused[by_socket], b, normal, none, by_socket);
    v->faults_excused_m = v->geometry_m = mukca_folds_mean(excused[0], rows);
    if (!as_recorded) return;
    m->unknowns.n_causes = 0;
    memcpy(m->recording.keep, b->all, (size_t)rows);
    mukca_recording_regroup(&m->recording);
    mukca_regression_fit(m, 3, MUKCA_FIT_NOISE);
    mukca_folds_run(b->error, b, mukca_regression_collect_own(m), none, false);
    mukca_folds_errors(b->error, m, b->position, b->all, false);
    v->geometry_m = mukca_folds_mean(b->error, rows);
}

/* What all causes together leave, and each alone. */
static mukca_status measure_causes(mukca_validation *v, mukca_folds *b, double *const excused[2],
                                   const mukca_findings *findings,
                                   const mukca_diagnose_options *options, mukca_error *error)
{
    mukca_regression *m = b->m;
    unsigned char use[MUKCA_MAX_ACCEPTED];
    memset(use, 1, sizeof use);
    mukca_normal_equations *normal = mukca_regression_collect_own(m);
    mukca_folds_run(b->error, b, normal, use, false);
    v->explained_m = mukca_folds_mean(b->error, m->recording.data->n_rows);
    if (b->freedom > 0) {
        v->surprise = sqrt(fmax(b->surprise, 0) / b->freedom);
        v->surprise_sigmas = (b->surprise - b->freedom) / sqrt(2.0 * b->freedom);
    }
    mukca_folds_compare(&v->shrink, b, excused[0], b->error);
    mukca_folds_by_placement(v->placement_m, &m->recording, b->error);
    for (int i = 0; i < findings->n_causes; i++) {
        const int c = find_accepted(m, &findings->causes[i]);
        if (c < 0 || !m->unknowns.cause[c].candidate.basis) continue;
        const bool by_socket = of_placement(&findings->causes[i].effect);
        if (options->progress &&
            !options->progress(options->progress_context, 0.7 + 0.2 * i / findings->n_causes,
                               "measuring on held-out rows"))
            return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
        memset(use, 0, sizeof use);
        use[c] = 1;
        mukca_folds_run(b->error, b, normal, use, by_socket);
        mukca_folds_compare(&v->cause[i], b, excused[by_socket], b->error);
    }
    return MUKCA_OK;
}

mukca_status mukca_cross_validation_run(mukca_validation *v, mukca_pool *pool, mukca_regression *m,
                                        const mukca_findings *findings,
                                        const mukca_diagnose_options *options, mukca_error *error)
{
    const int rows = m->recording.data->n_rows;
    mukca_folds b = {.m = m};
    mukca_folds_create(&b);
    double *const excused[2] = {MUKCA_TAKE(&m->pool, double, rows),
                                MUKCA_TAKE(&m->pool, double, rows)};
    unsigned char *kept = MUKCA_TAKE(&m->pool, unsigned char, rows);
    mukca_unknowns explained;
    mukca_unknowns_clone(&explained, &m->pool, &m->unknowns);
    mukca_cross_validation_clear(v);
    v->placement_m = MUKCA_TAKE(pool, double, m->recording.data->n_placements + 1);
    if (m->pool.failed || pool->failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", rows);
    v->folds = mukca_folds_assign(b.fold, m, false);
    v->noise_shrink_percent = noise_gain(m->recording.data->n_placements);
    memcpy(kept, m->recording.keep, (size_t)rows);
    for (int c = 0; c < m->unknowns.n_causes; c++)
        if (!mukca_candidate_is_fault(&m->unknowns.cause[c].candidate))
            mukca_unknowns_drop(&m->unknowns, c--);
    mukca_regression_fit(m, 4, MUKCA_FIT_ALL);
    measure_geometry(v, &b, excused);
    mukca_unknowns_assign(&m->unknowns, &explained);
    memcpy(m->recording.keep, kept, (size_t)rows);
    mukca_recording_regroup(&m->recording);
    mukca_regression_linearise(m);
    const mukca_status status =
        v->folds < 2 ? MUKCA_OK : measure_causes(v, &b, excused, findings, options, error);
    m->unknowns.geometry = explained.geometry;
    return status;
}
