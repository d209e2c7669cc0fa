/* Numbers of the report, computed from the arm, the data and the results. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/align.h"
#include "report/report.h"

/* Append the samples, sockets and placements of `from` to r->data, which has room for them. */
static void append(mukca_dataset *all, const mukca_dataset *from, int row, int socket,
                   int placement)
{
    const size_t values = (size_t)from->n_rows * (size_t)from->n_joints;
    if (values) memcpy(all->q + row * all->n_joints, from->q, values * sizeof *all->q);
    for (int i = 0; i < from->n_rows; i++)
        all->socket[row + i] = from->socket[i] < 0 ? -1 : socket + from->socket[i];
    for (int i = 0; all->position && i < 3 * from->n_rows; i++)
        all->position[3 * row + i] = from->position ? from->position[i] : (double)NAN;
    for (int k = 0; k < from->n_sockets; k++) {
        all->sockets[socket + k] = from->sockets[k];
        all->sockets[socket + k].placement += placement;
    }
    for (int p = 0; p < from->n_placements; p++)
        all->placements[placement + p] = from->placements[p];
}

/* Concatenate training and test samples to one dataset. */
static mukca_status join(mukca_report *r, mukca_error *error)
{
    mukca_dataset *all = &r->data;
    const mukca_dataset *train = r->train, *test = r->test;
    mukca_status status = mukca_dataset_create(all, train->n_rows + test->n_rows, train->n_joints,
                                               train->n_sockets + test->n_sockets,
                                               train->n_placements + test->n_placements, error);
    if (status != MUKCA_OK) return status;
    if (train->position || test->position) {
        all->position = calloc((size_t)all->n_rows, 3 * sizeof *all->position);
        if (!all->position) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    }
    append(all, train, 0, 0, 0);
    append(all, test, train->n_rows, train->n_sockets, train->n_placements);
    return MUKCA_OK;
}

/* Positions of ball or target of each sample, by models[0] for the training data and models[1] for
 * the test data, [n_rows][3]; NULL: out of memory. */
static double *positions(mukca_report *r, const mukca_model models[2])
{
    double *tips = MUKCA_TAKE(&r->pool, double, 3 * r->data.n_rows + 1);
    mukca_frame *frames = MUKCA_TAKE(&r->pool, mukca_frame, r->data.n_rows + 1);
    if (!tips || !frames) return NULL;
    mukca_frame *test = frames + r->train->n_rows;
    if (!mukca_evaluate_tips(frames, &models[0], r->train) ||
        !mukca_evaluate_tips(test, &models[1], r->test) ||
        !mukca_evaluate_place(frames, r->train) || !mukca_evaluate_place(test, r->test))
        return NULL;
    for (int i = 0; i < r->data.n_rows; i++) memcpy(tips + 3 * i, frames[i].p, sizeof frames[i].p);
    return tips;
}

/* Residuals of the tips from their socket's mean or from the measured position, [n_rows][3]; NULL:
 * out of memory. */
static double *residuals(mukca_report *r, const double *tips)
{
    const mukca_dataset *data = &r->data;
    double *residual = MUKCA_TAKE(&r->pool, double, 3 * data->n_rows + 1);
    double *sum = MUKCA_TAKE(&r->pool, double, 3 * data->n_sockets + 1);
    double *count = MUKCA_TAKE(&r->pool, double, data->n_sockets + 1);
    if (!tips || r->pool.failed) return NULL;
    for (int i = 0; i < data->n_rows; i++) {
        const int s = data->socket[i];
        if (s < 0) continue;
        count[s]++;
        for (int k = 0; k < 3; k++) sum[3 * s + k] += tips[3 * i + k];
    }
    for (int i = 0; i < data->n_rows; i++)
        for (int k = 0; k < 3; k++) {
            const int s = data->socket[i];
            const double truth = s < 0 ? data->position[3 * i + k] : sum[3 * s + k] / count[s];
            residual[3 * i + k] = tips[3 * i + k] - truth;
        }
    return residual;
}

/* Component of each residual along the ball's motion by each joint, r . J_j / |J_j|, m,
 * [n_rows][n_joints]; NULL: out of memory. */
static double *joint_errors(mukca_report *r, const mukca_chain *chain, const double *theta,
                            const double *residual)
{
    const int n = r->data.n_joints;
    double *errors = MUKCA_TAKE(&r->pool, double, r->data.n_rows *n + 1);
    mukca_geometry geometry;
    if (!errors || !residual) return NULL;
    mukca_geometry_set(&geometry, chain, theta);
    for (int i = 0; i < r->data.n_rows; i++) {
        double J[6 * MUKCA_MAX_JOINTS];
        mukca_fk_jacobian(J, NULL, &geometry, r->data.q + i * n, NULL);
        for (int j = 0; j < n; j++) {
            double dot = 0, square = 0;
            for (int k = 0; k < 3; k++) {
                dot += residual[3 * i + k] * J[k * n + j];
                square += J[k * n + j] * J[k * n + j];
            }
            /* below 1 um per rad the joint has no effect on the ball */
            errors[i * n + j] = square > 1e-12 && isfinite(dot) ? dot / sqrt(square) : 0;
        }
    }
    return errors;
}

/* Positions, residuals and their components by joint of model m; models[0] for the training data,
 * models[1] for the test data. */
static mukca_status predict(mukca_report *r, int m, const mukca_model models[2], mukca_error *error)
{
    r->tip[m] = positions(r, models);
    r->residual[m] = residuals(r, r->tip[m]);
    r->joint_error[m] = joint_errors(r, r->fitted, r->offsets->theta, r->residual[m]);
    return r->joint_error[m] && !r->pool.failed ? MUKCA_OK
                                                : mukca_fail(error, MUKCA_MEMORY, "out of memory");
}

/* Append the scores of a dataset. */
static mukca_status score(mukca_report *r, const mukca_dataset *data, const mukca_model *nominal,
                          const mukca_model *calibrated, mukca_error *error)
{
    const int room = data->n_placements + 1;
    mukca_score *scores = MUKCA_TAKE(&r->pool, mukca_score, 2 * room), mean[2];
    int n = scores ? mukca_evaluate(scores, &mean[0], nominal, data) : -1;
    if (n >= 0) n = mukca_evaluate(scores + room, &mean[1], calibrated, data);
    if (n < 0) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    for (int i = 0; i < n; i++) {
        const int p = scores[i].placement;
        r->scores[r->n_scores++] =
            (mukca_report_score){.placement = p < 0 ? "poses" : data->placements[p].name,
                                 .test = data == r->test,
                                 .nominal = scores[i],
                                 .calibrated = scores[room + i]};
    }
    return MUKCA_OK;
}

mukca_status mukca_report_prepare(mukca_report *r, mukca_error *error)
{
    const mukca_dataset *data[2] = {r->train, r->test};
    double theta[MUKCA_MAX_THETA];
    mukca_model models[2];
    const mukca_model nominal = {.chain = r->fitted, .theta = theta},
                      rigid = {.chain = r->fitted, .theta = r->offsets->theta};
    mukca_status status = join(r, error);
    if (status == MUKCA_OK)
        status = mukca_frames_start(theta, r->fitted, r->train, r->free_base, r->free_tool, error);
    if (status != MUKCA_OK) return status;
    r->scores = MUKCA_TAKE(&r->pool, mukca_report_score, r->data.n_placements + 2);
    r->offset = MUKCA_TAKE(&r->pool, mukca_offset_row, MUKCA_MAX_OFFSET_ROWS);
    mukca_effect *effects = MUKCA_TAKE(&r->pool, mukca_effect, 2 * MUKCA_MAX_EFFECTS);
    if (r->pool.failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    r->n_offsets = mukca_offsets_rows(r->offset, r->offsets, r->fitted);
    for (int k = 0; k < 2 && status == MUKCA_OK; k++) {
        mukca_effect *placed = effects + k * MUKCA_MAX_EFFECTS;
        mukca_offsets_place_effects(placed, r->offsets, data[k]);
        models[k] = (mukca_model){.chain = r->fitted,
                                  .theta = r->offsets->theta,
                                  .effects = placed,
                                  .n_effects = r->offsets->n_effects};
        if (data[k]->n_rows > 0) status = score(r, data[k], &nominal, &models[k], error);
    }
    const mukca_model of[MUKCA_REPORT_MODELS][2] = {
        {nominal, nominal}, {rigid, rigid}, {models[0], models[1]}};
    for (int m = 0; m < MUKCA_REPORT_MODELS && status == MUKCA_OK; m++)
        status = predict(r, m, of[m], error);
    return status;
}

void mukca_report_free(mukca_report *r)
{
    mukca_dataset_free(&r->data);
    mukca_pool_free(&r->pool);
}
