/* Leave folds of rows out of the fit, predict them, and compare the errors.
 *
 * The model is linearised once.  Leaving a fold out subtracts its part of the normal equations; the
 * unknowns that the rest gives are put into the full kinematics to predict the rows of the fold.
 */
#include "diagnose/folds.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "math/dense.h"
#include "math/random.h"
#include "math/stats.h"

enum { POSE_FOLDS = 5, DRAWS = 400 };

void gap_left_out_take(gap_left_out *b)
{
    gap_model *m = b->m;
    const int rows = m->data->n_rows;
    b->fold = MUKCA_TAKE(&m->pool, int, rows);
    b->prior = MUKCA_TAKE(&m->pool, double, m->capacity);
    b->gram = MUKCA_TAKE(&m->pool, double, (m->capacity + 1) * (m->capacity + 1));
    b->distance = MUKCA_TAKE(&m->pool, double, (m->data->n_distances + 1) * (m->capacity + 1));
    b->position = MUKCA_TAKE(&m->pool, double, 3 * rows);
    b->error = MUKCA_TAKE(&m->pool, double, rows);
    b->all = MUKCA_TAKE(&m->pool, unsigned char, rows);
    if (b->all) memset(b->all, 1, (size_t)rows);
}

int gap_left_out_folds(int *fold, const gap_model *m, bool by_socket)
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

void gap_left_out_errors(double *error, const gap_model *m, const double *position,
                         const unsigned char *of, bool excuse)
{
    const mukca_dataset *data = m->data;
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
                        error[row] = sqrt(mukca_dot3(e, e));
                    }
                }
        }
    }
}

double gap_left_out_mean(const double *error, int n)
{
    double sum = 0;
    int count = 0;
    for (int i = 0; i < n; i++)
        if (isfinite(error[i])) sum += error[i], count++;
    return count ? sum / count : (double)NAN;
}

bool gap_left_out_fault(const gap_hypothesis *h)
{
    return h->kind == GAP_STEP || h->kind == GAP_CREEP || h->kind == GAP_SPIKE;
}

/* Prior sigmas with only the causes that `use` marks (and the faults of the tool). */
static void priors_of(gap_left_out *b, const unsigned char *use)
{
    const gap_model *m = b->m;
    gap_model_prior(b->prior, m, -1);
    int column = m->n_geometry;
    for (int c = 0; c < m->n_causes; c++) {
        const gap_hypothesis *h = &m->cause[c].hypothesis;
        for (int t = 0; t < h->terms; t++, column++)
            if (!gap_left_out_fault(h) && !use[c]) b->prior[column] = 0;
    }
}

/* Fit without each fold in turn and predict it; the model must be linearised, `pack` filled.
 *
 * With Gaussians, -2 log p(fold | rest) has the quadratic part Q(all) - Q(rest): the fold's squared
 * misfit with noise and with what the rest leaves open, all correlations of its rows included. */
static void cross_predict(gap_left_out *b, gap_pack *pack, const unsigned char *use)
{
    gap_model *m = b->m;
    const int size = m->n_columns + 1, d = m->dim;
    double *mean = m->mean;
    for (int i = 0; i < 3 * m->data->n_rows; i++) b->position[i] = NAN; /* not predicted */
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

gap_pack *gap_left_out_pack(gap_model *m)
{
    gap_pack *pack = &m->pack[0];
    for (int i = 0; i < GAP_RHOS; i++)
        if (gap_rho[i] == m->rho) pack = &m->pack[i];
    gap_model_pack(pack, m, m->rho);
    return pack;
}

void gap_left_out_run(double *error, gap_left_out *b, gap_pack *pack, const unsigned char *use,
                      bool by_socket)
{
    b->n_folds = gap_left_out_folds(b->fold, b->m, by_socket);
    cross_predict(b, pack, use);
    gap_left_out_errors(error, b->m, b->position, b->m->keep, true);
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

void gap_left_out_compare(mukca_shrink *shrink, const gap_left_out *b, const double *before,
                          const double *after)
{
    const mukca_dataset *data = b->m->data;
    shrink->before_m = gap_left_out_mean(before, data->n_rows);
    shrink->after_m = gap_left_out_mean(after, data->n_rows);
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
