/* The report: its numbers, computed from the arm, the data and the results; its sections in reading
 * order. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/align.h"
#include "report/report.h"

/* Positions of ball or target of each sample, [n_rows][3]; NULL: out of memory. */
static double *positions(mukca_report *r, const mukca_model *model)
{
    const int rows = r->train->n_rows;
    double *tips = MUKCA_TAKE(&r->pool, double, 3 * rows + 1);
    mukca_frame *frames = MUKCA_TAKE(&r->pool, mukca_frame, rows + 1);
    if (!tips || !frames || !mukca_evaluate_tips(frames, model, r->train) ||
        !mukca_evaluate_place(frames, r->train))
        return NULL;
    for (int i = 0; i < rows; i++) memcpy(tips + 3 * i, frames[i].p, sizeof frames[i].p);
    return tips;
}

/* Residuals of the tips from their socket's mean or from the measured position, [n_rows][3]; NULL:
 * out of memory. */
static double *residuals(mukca_report *r, const double *tips)
{
    const mukca_dataset *data = r->train;
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
    const mukca_dataset *data = r->train;
    const int n = data->n_joints;
    double *errors = MUKCA_TAKE(&r->pool, double, data->n_rows *n + 1);
    mukca_geometry geometry;
    if (!errors || !residual) return NULL;
    mukca_geometry_set(&geometry, chain, theta);
    for (int i = 0; i < data->n_rows; i++) {
        double J[6 * MUKCA_MAX_JOINTS];
        mukca_fk_jacobian(J, NULL, &geometry, data->q + i * n, NULL);
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

/* Positions, residuals and their components by joint of model m. */
static mukca_status predict(mukca_report *r, int m, const mukca_model *model, mukca_error *error)
{
    r->tip[m] = positions(r, model);
    r->residual[m] = residuals(r, r->tip[m]);
    r->joint_error[m] = joint_errors(r, r->fitted, r->offsets->theta, r->residual[m]);
    return r->joint_error[m] && !r->pool.failed ? MUKCA_OK
                                                : mukca_fail(error, MUKCA_MEMORY, "out of memory");
}

/* Score a dataset, 0: `train`, 1: `test`. */
static mukca_status score(mukca_report *r, int set, const mukca_model *const models[2],
                          mukca_error *error)
{
    const mukca_dataset *data = set ? r->test : r->train;
    for (int m = 0; m < 2 && r->n_scores[set] >= 0; m++) {
        mukca_score mean, *scores = MUKCA_TAKE(&r->pool, mukca_score, data->n_placements + 1);
        r->n_scores[set] = scores ? mukca_evaluate(scores, &mean, models[m], data) : -1;
        r->score[set][m] = scores;
    }
    return r->n_scores[set] >= 0 ? MUKCA_OK : mukca_fail(error, MUKCA_MEMORY, "out of memory");
}

mukca_status mukca_report_prepare(mukca_report *r, mukca_error *error)
{
    const mukca_dataset *data[2] = {r->train, r->test};
    double theta[MUKCA_MAX_THETA];
    mukca_model models[2];
    const mukca_model nominal = {.chain = r->fitted, .theta = theta},
                      rigid = {.chain = r->fitted, .theta = r->offsets->theta};
    mukca_status status =
        mukca_frames_start(theta, r->fitted, r->train, r->free_base, r->free_tool, error);
    if (status != MUKCA_OK) return status;
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
        if (data[k]->n_rows > 0)
            status = score(r, k, (const mukca_model *const[]){&nominal, &models[k]}, error);
    }
    const mukca_model *of[MUKCA_REPORT_MODELS] = {&nominal, &rigid, &models[0]};
    for (int m = 0; m < MUKCA_REPORT_MODELS && status == MUKCA_OK; m++)
        status = predict(r, m, of[m], error);
    return status;
}

void mukca_report_free(mukca_report *r)
{
    mukca_pool_free(&r->pool);
}

/* ---- the page ---- */

static const mukca_page_section sections[] = {
    {"causes", "Errors and their causes", NULL, mukca_report_put_causes},
    {"view", "The arm", NULL, mukca_report_put_view},
    {"placements", "Errors of the result", NULL, mukca_report_put_placements},
    {"joints", "Errors by joint", mukca_report_joints, mukca_report_put_joints},
    {"limits", "Detection limits", NULL, mukca_report_put_limits},
    {"faults", "Recording faults", NULL, mukca_report_put_faults},
    {"offsets", "Parameters", NULL, mukca_report_put_offsets},
    {"provenance", "Provenance", NULL, mukca_report_put_provenance},
};

static void open_page(FILE *out, const void *content)
{
    mukca_report_put_accuracy(out, content);
    mukca_report_put_verdict(out, content);
}

mukca_page mukca_report_page(const mukca_report *r)
{
    return (mukca_page){.robot = r->chain->robot,
                        .kind = "calibration report",
                        .from = r->free_base ? "the tracker's frame" : r->chain->base,
                        .to = r->free_tool ? "the target" : r->chain->tip,
                        .when = r->when,
                        .open = open_page,
                        .sections = sections,
                        .n_sections = sizeof sections / sizeof *sections,
                        .content = r};
}
