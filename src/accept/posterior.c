/* Posterior of an arm given samples. */
#include "accept/posterior.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "model/dataset_subset.h"

enum { STEPS = 4 /* of Gauss-Newton */ };

/* An error of the nominal arm's distance, m, that is that of a label, as in diagnose. */
static const double wrong_label = 0.02;

/* Move the mean of n by another one. */
static void add_to_mean(double *mean, const double *x, int n, int count)
{
    for (int i = 0; i < n; i++) mean[i] += (x[i] - mean[i]) / count;
}

static bool same_group(const mukca_dataset *d, int a, int b)
{
    return d->socket[a] == d->socket[b] &&
           (d->socket[a] >= 0 ||
            (d->file[a] == d->file[b] && mukca_dataset_target(d, a) == mukca_dataset_target(d, b)));
}

/* Count the postures, and take the mean of the readings of each in each socket and log: they share
 * errors. */
static mukca_status take_postures(mukca_arm_posterior *p, mukca_error *error)
{
    mukca_dataset *d = &p->data;
    const int n = d->n_joints;
    int *posture = MUKCA_TAKE(&p->pool, int, d->n_rows),
        *count = MUKCA_TAKE(&p->pool, int, d->n_rows);
    unsigned char *keep = MUKCA_TAKE(&p->pool, unsigned char, d->n_rows);
    if (p->pool.failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    p->postures = d->n_rows - mukca_postures_find(posture, &p->pool, d);
    for (int row = 0; row < d->n_rows; row++) {
        const double *position = d->position ? d->position + 3 * (size_t)row : NULL;
        int k = posture[row];
        if (d->socket[row] < 0 && !(position && isfinite(*position))) continue;
        while (k < row && !(keep[k] && posture[k] == posture[row] && same_group(d, k, row))) k++;
        keep[k] = 1;
        if (++count[k] == 1) continue;
        add_to_mean(d->q + k * n, d->q + row * n, n, count[k]);
        if (d->socket[row] < 0 && position)
            add_to_mean(d->position + 3 * (size_t)k, position, 3, count[k]);
    }
    return mukca_dataset_reduce(d, keep, error);
}

/* Leave out the distances that the nominal arm misses by a wrong label, unless no other is left:
 * the arm would shrink. */
static void choose_distances(mukca_arm_posterior *p)
{
    mukca_recording *r = &p->m.recording;
    int kept = 0;
    for (int k = 0; k < r->n_pairs; k++) {
        const mukca_socket_pair pair = r->pairs[k];
        const double length = mukca_distance3(p->m.linear.mean[pair.a], p->m.linear.mean[pair.b]);
        if (fabs(length - pair.distance) < wrong_label) r->pairs[kept++] = pair;
    }
    if (kept) r->n_pairs = kept;
}

/* Add an effect as a cause whose prior is three times its coefficients, or `least`. */
static bool add_effect(mukca_arm_posterior *p, const mukca_effect *effect, double least)
{
    mukca_unknowns *u = &p->m.unknowns;
    mukca_candidate h = mukca_candidate_of(effect);
    h.as_one = true;
    if (!mukca_candidate_prepare(&h, &p->m.pool, &p->m.recording)) return false;
    if (!mukca_unknowns_add(u, &h)) return true; /* full */
    mukca_accepted *cause = &u->cause[u->n_causes - 1];
    cause->known = true;
    cause->scale = 0;
    for (int t = 0; t < h.terms; t++)
        cause->scale =
            fmax(cause->scale, fmax(3 * fabs(effect->coefficient[t]), least) * h.unit[t]);
    return true;
}

static bool add_table(mukca_arm_posterior *p)
{
    const mukca_offsets *table = p->task->to;
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    if (table) mukca_offsets_place_effects(effects, table, &p->data);
    for (int e = 0; table && e < table->n_effects; e++)
        if (!add_effect(p, &effects[e], 1e-12)) return false;
    return true;
}

/* Fit, and factor the posterior. */
static void fit(mukca_arm_posterior *p, int steps)
{
    mukca_regression *m = &p->m;
    const mukca_recording *r = &m->recording;
    mukca_regression_fit_tails(m, p->weight, steps);
    const double *y = mukca_evidence_deviations(&m->evidence, p->weight);
    for (int i = 0; i < r->n_samples; i++)
        memcpy(p->residual[r->order[i]], y + i * r->dim, sizeof *p->residual);
}

static mukca_status create(mukca_arm_posterior *p, const mukca_tip_change_task *task,
                           mukca_error *error)
{
    memset(p, 0, sizeof *p);
    p->task = task;
    p->chain = *task->chain;
    if (task->base_frame) mukca_chain_remove_first(&p->chain); /* of the measurement */
    MUKCA_TRY(mukca_part_take(&p->data, task->data, MUKCA_MOST_SAMPLES, error));
    free(p->data.quaternion); /* their convention may be wrong */
    free(p->data.effort);     /* the table's effects are for the model's masses */
    p->data.quaternion = p->data.effort = NULL;
    MUKCA_TRY(take_postures(p, error));
    const bool tool = task->tool_frame || p->data.n_targets > 0;
    return mukca_regression_create(
        &p->m, &p->chain, &p->data,
        &(mukca_recording_options){.free_base = task->base_frame || task->free_base,
                                   .free_tool = tool,
                                   .base_per_log = true,
                                   .tool_per_log = tool,
                                   .threads = task->threads},
        error);
}

mukca_status mukca_arm_posterior_fit(mukca_arm_posterior *p, const mukca_tip_change_task *task,
                                     mukca_error *error)
{
    MUKCA_TRY(create(p, task, error));
    p->weight = MUKCA_TAKE(&p->pool, double, p->data.n_rows);
    p->residual = MUKCA_TAKE(&p->pool, double[3], p->data.n_rows);
    if (p->pool.failed || !add_table(p)) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    mukca_unknowns *u = &p->m.unknowns;
    u->prior = mukca_prior_expected;
    p->m.evidence.expected = 10;
    mukca_regression_linearise(&p->m);
    choose_distances(p);
    fit(p, STEPS);
    return MUKCA_OK;
}

mukca_status mukca_arm_posterior_extend(double *evidence, mukca_arm_posterior *p,
                                        const mukca_effect *effects, int n, mukca_error *error)
{
    mukca_unknowns *u = &p->m.unknowns;
    const int first = u->n_causes;
    const double without = mukca_regression_factor(&p->m);
    double scale[MUKCA_MAX_ACCEPTED], best = -HUGE_VAL, chosen = 1, part = 1;
    for (int i = 0; i < n; i++)
        if (!add_effect(p, &effects[i], 0)) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    for (int c = first; c < u->n_causes; c++) scale[c] = u->cause[c].scale;
    mukca_regression_linearise(&p->m);
    for (int step = 0; step < 6; step++, part /= 2) { /* part of all sizes together */
        for (int c = first; c < u->n_causes; c++) u->cause[c].scale = part * scale[c];
        const double value = mukca_regression_factor(&p->m);
        if (value > best) best = value, chosen = part;
    }
    for (int c = first; c < u->n_causes; c++) u->cause[c].scale = chosen * scale[c];
    *evidence = best - without;
    fit(p, 1);
    return MUKCA_OK;
}

/* The same unknowns for other postures: their linearisation. */
static bool linearise(mukca_linearisation *linear, mukca_recording *r, mukca_pool *pool,
                      const mukca_arm_posterior *p, const mukca_dataset *postures)
{
    mukca_unknowns u = p->m.unknowns;
    bool ok = mukca_recording_create(r, pool, &p->chain, postures, &(mukca_recording_options){0}) &&
              mukca_unknowns_clone(&u, pool, &p->m.unknowns);
    for (int c = 0; ok && c < u.n_causes; c++)
        ok = mukca_candidate_prepare(&u.cause[c].candidate, pool, r);
    ok = ok && mukca_linearisation_create(linear, pool, r, &u);
    if (ok) mukca_linearisation_update(linear, &u);
    return ok;
}

bool mukca_arm_posterior_probe(double *X, int ld, mukca_arm_posterior *p, const double *q, int n)
{
    mukca_pool pool = {0};
    mukca_error unsaid;
    mukca_dataset postures = {0};
    mukca_recording r;
    mukca_linearisation linear;
    const size_t joints = (size_t)p->chain.n_joints;
    const int columns = p->m.linear.n_columns;
    bool ok = !mukca_dataset_create(&postures, n, p->chain.n_joints, 0, 0, &unsaid);
    if (ok) memcpy(postures.q, q, (size_t)n * joints * sizeof *q);
    postures.position = calloc(3 * (size_t)n + 1, sizeof *postures.position);
    ok = ok && postures.position && linearise(&linear, &r, &pool, p, &postures);
    memset(X, 0, 3 * (size_t)n * (size_t)ld * sizeof *X);
    for (int i = 0; i < n && ok; i++)
        for (int a = 0; a < 3; a++, X += ld) {
            const double *tip = linear.tip + 3 * i, *R = linear.tip_frame + 9 * i + 3 * a;
            X[a] = 1;
            X[3 + (a + 1) % 3] = tip[(a + 2) % 3];
            X[3 + (a + 2) % 3] = -tip[(a + 1) % 3];
            if (p->m.unknowns.free_tool) memcpy(X + 6, R, 3 * sizeof *R);
            memcpy(X + MUKCA_RIGID, linear.columns + (size_t)(3 * i + a) * (size_t)linear.stride,
                   (size_t)columns * sizeof *X);
            X[MUKCA_RIGID + columns] = -tip[a];
        }
    mukca_pool_free(&pool);
    mukca_dataset_free(&postures);
    return ok;
}

void mukca_arm_posterior_free(mukca_arm_posterior *p)
{
    mukca_regression_free(&p->m);
    mukca_dataset_free(&p->data);
    mukca_pool_free(&p->pool);
}
