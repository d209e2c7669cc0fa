/* Folds: fits without part of the rows, predictions of that part, and comparison of the errors.
 *
 * The model is linearised once.  A fold is left out by subtraction from the normal equations; the
 * solution for the rest predicts the fold's rows by full kinematics. */
#include "diagnose/held_out.h"

#include <math.h>
#include <string.h>

#include "fit/evaluate.h"
#include "math/dense.h"
#include "math/random.h"
#include "math/stats.h"

enum { LEAST_POSES = 3, DRAWS = 400 }; /* three determine a frame */

void mukca_folds_create(mukca_folds *b)
{
    mukca_regression *m = b->m;
    const int rows = m->recording.data->n_rows;
    const int size = mukca_unknowns_capacity(&m->unknowns) + 1;
    b->fold = MUKCA_TAKE(&m->pool, int, rows);
    b->rest.all_gram = MUKCA_TAKE(&m->pool, double, size *size);
    b->rest.all_distance = MUKCA_TAKE(&m->pool, double, m->recording.data->n_distances *size);
    b->position = MUKCA_TAKE(&m->pool, double, 3 * rows);
    b->error = MUKCA_TAKE(&m->pool, double, rows);
    b->start = MUKCA_TAKE(&m->pool, int, m->recording.data->n_sockets + 2);
    b->row = MUKCA_TAKE(&m->pool, int, rows);
}

int mukca_folds_assign(int *fold, const mukca_regression *m, bool by_socket)
{
    const mukca_dataset *data = m->recording.data;
    const int *log = m->recording.log;
    int n = 0, poses = 0, of_log[MUKCA_MAX_LOGS] = {0}, done[MUKCA_MAX_LOGS] = {0};
    for (int row = 0; row < data->n_rows; row++)
        if (data->socket[row] < 0) of_log[log[row]]++, poses += poses < MUKCA_POSE_FOLDS;
    const bool sockets = by_socket || data->n_placements < 2;
    n = sockets ? data->n_sockets : data->n_placements;
    for (int row = 0; row < data->n_rows; row++) {
        const int g = log[row], posture = m->recording.posture[row];
        fold[row] = sockets ? data->socket[row] : m->recording.placement[row];
        if (data->socket[row] >= 0) continue;
        /* a block of each log: the rest determines its frames */
        fold[row] = n + (int)((long long)poses * done[g]++ / of_log[g]);
        if (m->recording.repeats && posture < row && data->socket[posture] < 0)
            fold[row] = fold[posture]; /* readings of a posture share errors */
    }
    return n + (poses > LEAST_POSES ? poses : 0);
}

/* The known motion of the tool in a socket; NULL: none. */
static const mukca_candidate *motion_of(const mukca_regression *m, int socket)
{
    for (int c = 0; c < m->unknowns.n_causes; c++) {
        const mukca_candidate *h = &m->unknowns.cause[c].candidate;
        if (h->kind == MUKCA_CANDIDATE_MOTION &&
            m->recording.groups[h->fault.group].socket == socket)
            return h;
    }
    return NULL;
}

/* The next row of a socket, marked in `marked` (NULL: all are), after `row`; -1: none. */
static int next_row(const mukca_dataset *data, const unsigned char *marked, int socket, int row)
{
    while (++row < data->n_rows)
        if ((!marked || marked[row]) && data->socket[row] == socket) return row;
    return -1;
}

/* Errors of a socket's rows about their mean, or about their line over the share of the tool's
 * motion. */
static void socket_errors(double *error, const mukca_regression *m, const double *position,
                          const unsigned char *marked, int socket, const mukca_candidate *motion)
{
    const mukca_dataset *data = m->recording.data;
    double n = 0, mean[4] = {0}, slope[3] = {0}, square = 0; /* position, share of the motion */
    for (int pass = 0; pass < 3; pass++)
        for (int row = -1; (row = next_row(data, marked, socket, row)) >= 0;) {
            double d[4];
            for (int c = 0; c < 3; c++) d[c] = position[3 * row + c] - mean[c];
            d[3] = (motion ? mukca_candidate_fault_share(motion, &m->recording, row) : 0) - mean[3];
            if (pass == 0) n++;
            for (int c = 0; c < 4 && pass == 0; c++) mean[c] += d[c] / n;
            for (int c = 0; c < 3 && pass == 1; c++) slope[c] += d[3] * d[c];
            if (pass == 1) square += d[3] * d[3];
            for (int c = 0; c < 3 && square > 0; c++) d[c] -= d[3] / square * slope[c];
            error[row] = mukca_norm3(d);
        }
}

void mukca_folds_errors(double *error, const mukca_regression *m, const double *position,
                        const unsigned char *marked, bool excuse)
{
    const mukca_dataset *data = m->recording.data;
    for (int row = 0; row < data->n_rows; row++)
        error[row] = (!marked || marked[row]) && data->socket[row] < 0
                         ? mukca_distance3(data->position + 3 * (size_t)row, position + 3 * row)
                         : (double)NAN;
    for (int s = 0; s < data->n_sockets; s++)
        socket_errors(error, m, position, marked, s, excuse ? motion_of(m, s) : NULL);
}

/* Mean of the finite errors with key[n] equal to `group`; key NULL: of all. */
static double mean_of(const double *error, int n, const int *key, int group)
{
    double sum = 0;
    int count = 0;
    for (int i = 0; i < n; i++)
        if (isfinite(error[i]) && (!key || key[i] == group)) sum += error[i], count++;
    return count ? sum / count : (double)NAN;
}

double mukca_folds_mean(const double *error, int n)
{
    return mean_of(error, n, NULL, 0);
}

void mukca_folds_by_placement(double *mean, const mukca_recording *recording, const double *error)
{
    for (int p = 0; p < recording->data->n_placements; p++)
        mean[p] = mean_of(error, recording->data->n_rows, recording->placement, p);
}

/* b->rest := the normal equations without the samples of fold f and the distances of its sockets.
 */
static void subtract_fold(mukca_folds *b, const mukca_normal_equations *normal, int f)
{
    const mukca_recording *r = &b->m->recording;
    const int ld = b->m->linear.stride;
    const double *X = mukca_evidence_whiten(&b->m->evidence, normal);
    double *gram = b->rest.all_gram, *distance = b->rest.all_distance;
    mukca_evidence_multiply(gram, X, ld, r, b->fold, f);
    for (int i = 0; i < ld * ld; i++) gram[i] = normal->all_gram[i] - gram[i];
    for (int p = 0; p < r->n_pairs; p++) {
        const int a = r->order[r->groups[r->pairs[p].a].start];
        const int c = r->order[r->groups[r->pairs[p].b].start];
        const double by = b->fold[a] == f || b->fold[c] == f ? 0 : 1;
        for (int k = p * ld; k < (p + 1) * ld; k++) distance[k] = by * normal->all_distance[k];
    }
    b->rest = *normal;
    b->rest.all_gram = gram, b->rest.all_distance = distance;
}

/* Fit without each fold in turn and predict it; the model must be linearised. */
static void cross_predict(mukca_folds *b)
{
    mukca_regression *m = b->m;
    const mukca_recording *r = &m->recording;
    mukca_unknowns *unknowns = &m->unknowns, fitted;
    for (int i = 0; i < 3 * r->data->n_rows; i++) b->position[i] = NAN; /* not predicted */
    if (!mukca_unknowns_clone(&fitted, &m->pool, unknowns)) return;
    for (int f = 0; f < b->n_folds; f++) {
        subtract_fold(b, mukca_regression_collect(m, m->unknowns.family), f);
        if (mukca_regression_average(m, &b->rest)) {
            mukca_unknowns_set(unknowns, m->evidence.mean);
            mukca_unknowns_fold_frames(unknowns);
            mukca_unknowns_set_geometry(unknowns, r->chain);
            for (int row = 0; row < r->data->n_rows; row++)
                if (b->fold[row] == f)
                    mukca_unknowns_predict(b->position + 3 * row, unknowns, r, row);
        }
        mukca_unknowns_assign(unknowns, &fitted);
    }
}

void mukca_folds_run(double *error, mukca_folds *b, bool by_socket)
{
    b->n_folds = mukca_folds_assign(b->fold, b->m, by_socket);
    cross_predict(b);
    mukca_folds_errors(error, b->m, b->position, b->m->recording.keep, true);
}

/* Interval of the reduction by resampling sockets, and rows within them. */
static void bootstrap(mukca_shrink *shrink, const mukca_folds *b, const double *before,
                      const double *after)
{
    const mukca_dataset *data = b->m->recording.data;
    double draw[DRAWS];
    int groups = data->n_sockets, n = 0, *start = b->start, *rows = b->row;
    mukca_random random = mukca_random_seeded(20240917);
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
}

void mukca_folds_compare(mukca_shrink *shrink, const mukca_folds *b, const double *before,
                         const double *after)
{
    const mukca_dataset *data = b->m->recording.data;
    shrink->before_m = mukca_folds_mean(before, data->n_rows);
    shrink->after_m = mukca_folds_mean(after, data->n_rows);
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
        shrink->folds_better += sum[1] < sum[0] * (1 - 1e-9); /* beyond rounding */
    }
    bootstrap(shrink, b, before, after);
}
