/* Cross-validation: reduction of the error on held-out samples. */
#include "diagnose/held_out.h"

#include <math.h>
#include <string.h>

#include "diagnose/findings.h"

/* Must the folds be sockets?  An effect of one placement cannot be predicted without this
 * placement.  With two placements, the geometry fitted to one is so uncertain that its error hides
 * the effect of a cause. */
static bool needs_sockets(const mukca_effect *effect, const mukca_recording *recording)
{
    return recording->data->n_placements == 2 ||
           (mukca_effect_has((int)effect->kind, MUKCA_TRAIT_PER_PLACEMENT) &&
            !mukca_effect_has((int)effect->kind, MUKCA_TRAIT_RECORDING_FAULT));
}

double mukca_held_out_structure(mukca_regression *m)
{
    mukca_folds b = {.m = m};
    mukca_folds_create(&b);
    if (m->pool.failed || mukca_folds_assign(b.fold, m, false) < 2) return NAN;
    mukca_folds_run(b.error, &b, false);
    return mukca_folds_mean(b.error, m->recording.data->n_rows);
}

/* Remaining error of the geometry, by axis. */
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

/* Errors of the nominal geometry, of one fitted with faulty rows excused (excused[n_rows]), and of
 * one fitted to all rows as recorded.  The regression has no causes but faults; at return it has
 * none. */
static void measure_geometry(mukca_diagnosis *d, mukca_arm_state *geometry, mukca_folds *b,
                             double *excused)
{
    mukca_regression *m = b->m;
    mukca_unknowns *u = &m->unknowns;
    const int rows = m->recording.data->n_rows;
    const bool as_recorded = u->n_causes > 0 || m->recording.n_samples < rows;
    *geometry = u->arm;
    measure_axes(d->axis_rms_m, m);
    u->arm = mukca_unknowns_nominal_arm(u, m->recording.chain);
    for (int row = 0; row < rows; row++)
        mukca_unknowns_predict(b->position + 3 * row, u, &m->recording, row);
    u->arm = *geometry;
    mukca_folds_errors(d->before_m, m, b->position, m->recording.keep, true);
    mukca_folds_errors(b->error, m, b->position, NULL, false);
    d->nominal_m = mukca_folds_mean(b->error, rows);
    if (d->folds < 2) return;
    mukca_folds_run(excused, b, false);
    d->faults_excused_m = d->geometry_m = mukca_folds_mean(excused, rows);
    if (!as_recorded) return;
    u->n_causes = 0;
    memset(m->recording.keep, 1, (size_t)rows);
    mukca_recording_regroup(&m->recording);
    mukca_regression_fit(m, 3, MUKCA_FIT_INDEPENDENT);
    mukca_folds_run(b->error, b, false);
    mukca_folds_errors(b->error, m, b->position, NULL, false);
    d->geometry_m = mukca_folds_mean(b->error, rows);
}

/* State of the measurement; errors of all identified causes with placements and with sockets as
 * folds. */
typedef struct {
    mukca_diagnosis *d;
    mukca_folds *b;
    const mukca_diagnose_options *options;
    double *excused, *full[2]; /* [n_rows] */
    mukca_unknowns *all;
} measurement;

/* Error of all identified causes together. */
static void measure_explained(measurement *s)
{
    mukca_diagnosis *d = s->d;
    mukca_folds *b = s->b;
    bool by_socket = false;
    for (int i = 0; i < s->d->n_causes; i++)
        by_socket |= needs_sockets(&s->d->causes[i].effect, &b->m->recording);
    for (int f = 0; f < s->d->n_findings; f++)
        by_socket |= s->d->findings[f].group.family == MUKCA_VARIES_PLACEMENT;
    if (by_socket) mukca_folds_run(s->full[1], b, true);
    mukca_folds_run(s->full[0], b, false);
    d->explained_m = mukca_folds_mean(s->full[0], b->m->recording.data->n_rows);
    memcpy(d->after_m, s->full[0], sizeof *d->after_m * (size_t)b->m->recording.data->n_rows);
    mukca_folds_compare(&d->held_out, b, s->excused, s->full[0]);
    mukca_folds_by_placement(d->placement_mae_m, &b->m->recording, s->full[0]);
}

/* The i-th identified cause among those fitted, if it acts on the arm; -1: none. */
static int acting(const measurement *s, int i)
{
    const mukca_unknowns *u = &s->b->m->unknowns;
    for (int c = 0; c < u->n_causes; c++) {
        const mukca_candidate *h = &u->cause[c].candidate;
        if (h->kind == MUKCA_CANDIDATE_EFFECT && h->basis &&
            mukca_effect_same(&h->effect, &s->d->causes[i].effect))
            return c;
    }
    return -1;
}

/* Error without a cause, fitted again, since the geometry absorbs part of it. */
static void measure_without(measurement *s, int cause, bool by_socket)
{
    mukca_unknowns_drop(&s->b->m->unknowns, cause);
    mukca_regression_fit(s->b->m, 3, MUKCA_FIT_UNKNOWNS);
    mukca_folds_run(s->b->error, s->b, by_socket);
}

/* Report the part of the work that is done.  Errors: MUKCA_INTERRUPTED. */
static mukca_status report(const measurement *s, double done, mukca_error *error)
{
    const mukca_diagnose_options *o = s->options;
    if (!o->progress || o->progress(o->progress_context, done, "measuring on held-out samples"))
        return MUKCA_OK;
    return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
}

/* Error without each cause in turn; then with the first cause, with the first two, ... */
static mukca_status measure_causes(measurement *s, mukca_error *error)
{
    mukca_regression *m = s->b->m;
    mukca_diagnosis *d = s->d;
    const int n = d->n_causes;
    for (int i = 0; i < n; i++) {
        const int c = acting(s, i);
        if (c < 0) continue;
        const bool by_socket = needs_sockets(&d->causes[i].effect, &m->recording);
        MUKCA_TRY(report(s, 0.7 + 0.15 * i / n, error));
        measure_without(s, c, by_socket);
        mukca_folds_compare(&d->causes[i].held_out, s->b, s->b->error, s->full[by_socket]);
        mukca_unknowns_assign(&m->unknowns, s->all);
    }
    double rung = d->explained_m;
    for (int i = n - 1, last = -1; i >= 0; i--) {
        if (acting(s, i) < 0) continue;
        if (last >= 0) {
            measure_without(s, acting(s, last), false);
            rung = mukca_folds_mean(s->b->error, m->recording.data->n_rows);
        }
        d->causes[last = i].rung_m = rung;
    }
    mukca_unknowns_assign(&m->unknowns, s->all);
    return MUKCA_OK;
}

/* Error without all members of each finding. */
static mukca_status measure_findings(measurement *s, mukca_error *error)
{
    mukca_regression *m = s->b->m;
    mukca_unknowns *u = &m->unknowns;
    for (int f = 0; f < s->d->n_findings; f++) {
        const mukca_finding_group *g = &s->d->findings[f].group;
        int dropped = 0, alone = -1; /* the identified cause that is dropped */
        bool by_socket = false;
        MUKCA_TRY(report(s, 0.85 + 0.1 * f / s->d->n_findings, error));
        for (int c = u->n_causes - 1; c >= 0; c--) {
            const mukca_candidate *h = &u->cause[c].candidate;
            if (h->kind != MUKCA_CANDIDATE_EFFECT) continue;
            const mukca_label l = mukca_candidate_label(h, &m->recording, u);
            if (!mukca_finding_holds(g, &l)) continue;
            by_socket |= needs_sockets(&h->effect, &m->recording);
            for (int i = 0; i < s->d->n_causes; i++)
                if (acting(s, i) == c) alone = i;
            mukca_unknowns_drop(u, c);
            dropped++;
        }
        if (dropped == 1 && alone >= 0) {
            s->d->findings[f].held_out = s->d->causes[alone].held_out;
        } else if (dropped) {
            mukca_regression_fit(m, 3, MUKCA_FIT_UNKNOWNS);
            mukca_folds_run(s->b->error, s->b, by_socket);
            mukca_folds_compare(&s->d->findings[f].held_out, s->b, s->b->error, s->full[by_socket]);
        }
        if (dropped) mukca_unknowns_assign(u, s->all);
    }
    return MUKCA_OK;
}

mukca_status mukca_held_out_run(mukca_diagnosis *d, mukca_arm_state *geometry, mukca_regression *m,
                                const mukca_diagnose_options *options, mukca_error *error)
{
    const int rows = m->recording.data->n_rows;
    mukca_folds b = {.m = m};
    mukca_folds_create(&b);
    measurement s = {
        .d = d,
        .b = &b,
        .options = options,
        .all = MUKCA_TAKE(&m->pool, mukca_unknowns, 1),
        .excused = MUKCA_TAKE(&m->pool, double, rows),
        .full = {MUKCA_TAKE(&m->pool, double, rows), MUKCA_TAKE(&m->pool, double, rows)}};
    unsigned char *kept = MUKCA_TAKE(&m->pool, unsigned char, rows);
    d->placement_mae_m = MUKCA_TAKE(&d->pool, double, m->recording.data->n_placements + 1);
    d->before_m = MUKCA_TAKE(&d->pool, double, rows);
    d->after_m = MUKCA_TAKE(&d->pool, double, rows);
    if (!s.all || !mukca_unknowns_clone(s.all, &m->pool, &m->unknowns) || m->pool.failed ||
        d->pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", rows);
    for (int row = 0; row < rows; row++) d->after_m[row] = NAN;
    d->folds = mukca_folds_assign(b.fold, m, false);
    memcpy(kept, m->recording.keep, (size_t)rows);
    for (int c = 0; c < m->unknowns.n_causes; c++)
        if (!mukca_candidate_is_fault(&m->unknowns.cause[c].candidate))
            mukca_unknowns_drop(&m->unknowns, c--);
    mukca_regression_fit(m, 4, MUKCA_FIT_INDEPENDENT);
    measure_geometry(d, geometry, &b, s.excused);
    mukca_unknowns_assign(&m->unknowns, s.all);
    memcpy(m->recording.keep, kept, (size_t)rows);
    mukca_recording_regroup(&m->recording);
    mukca_status status = MUKCA_OK;
    if (d->folds > 1) {
        mukca_regression_freeze(m);
        measure_explained(&s);
        mukca_unknowns_assign(s.all, &m->unknowns);
        status = measure_causes(&s, error);
        if (status == MUKCA_OK) status = measure_findings(&s, error);
    }
    mukca_regression_linearise(m);
    return status;
}
