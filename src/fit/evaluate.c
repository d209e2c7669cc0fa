/* Errors of a model on data. */
#include "fit/evaluate.h"

#include <math.h>
#include <string.h>

#include "arm/tip_change.h"
#include "base/pool.h"
#include "fit/parameters.h"
#include "model/dataset_subset.h"

enum { TOGETHER = 64 }; /* samples whose positions are computed together */

/* Pose of the tip in each sample, its position alone where nothing else matters: tips[n_rows]; arm:
 * scratch. */
static void find_tips(mukca_frame *tips, mukca_chain *arm, const mukca_model *model,
                      const mukca_dataset *data)
{
    mukca_geometry geometry;
    mukca_row_state rows;
    mukca_frame base;
    *arm = *model->chain;
    mukca_geometry_set(&geometry, arm, model->theta);
    const bool framed = !strcmp(arm->element[0].name, MUKCA_BASE_FRAME);
    if (framed) {
        mukca_chain_remove_first(arm);
        base = geometry.origin[0];
        mukca_geometry_set(&geometry, arm, model->theta ? model->theta + MUKCA_PARAMETERS : NULL);
    }
    const bool sockets = model->n_effects == 0 && !data->position; /* positions suffice */
    double position[3 * TOGETHER];
    for (int row = 0; row < data->n_rows; row++) {
        const int k = row % TOGETHER, left = data->n_rows - row;
        if (sockets && k == 0)
            mukca_fk_positions(position, &geometry, data->q + (size_t)row * (size_t)data->n_joints,
                               left < TOGETHER ? left : TOGETHER);
        if (sockets)
            memcpy(tips[row].p, position + 3 * k, sizeof tips[row].p);
        else
            mukca_tip_pose(&tips[row], model->effects, model->n_effects, arm, &geometry,
                           mukca_dataset_state(&rows, data, row));
        if (framed) mukca_frame_multiply(&tips[row], &base, &tips[row]);
    }
}

/* Shift each tip to its named target, whose position in the tip's frame is the mean over the
 * measured positions; sum[n_targets], initially 0: scratch. */
static void place_tips(mukca_frame *tips, double (*sum)[4], const mukca_dataset *data)
{
    for (int pass = 0; pass < 2 && data->position; pass++)
        for (int i = 0; i < data->n_rows; i++) {
            const int t = mukca_dataset_target(data, i);
            const double *measured = data->position + 3 * i;
            double d[3], local[3];
            if (t < 0 || !isfinite(measured[0])) continue;
            if (pass == 0) {
                for (int a = 0; a < 3; a++) d[a] = measured[a] - tips[i].p[a];
                mukca_mat3_tvec(local, tips[i].R, d);
                for (int a = 0; a < 3; a++) sum[t][a] += local[a];
                sum[t][3]++;
            } else {
                for (int a = 0; a < 3; a++) local[a] = sum[t][a] / sum[t][3];
                mukca_mat3_vec(d, tips[i].R, local);
                for (int a = 0; a < 3; a++) tips[i].p[a] += d[a];
            }
        }
}

/* Means of the sockets: mean[n_sockets][3], count[n_sockets]. */
static void socket_means(double (*mean)[3], int *count, const mukca_frame *tips,
                         const mukca_dataset *data)
{
    for (int i = 0; i < data->n_rows; i++) {
        const int s = data->socket[i];
        if (s < 0) continue;
        count[s]++;
        for (int a = 0; a < 3; a++) mean[s][a] += tips[i].p[a];
    }
    for (int s = 0; s < data->n_sockets; s++)
        for (int a = 0; a < 3 && count[s] > 0; a++) mean[s][a] /= count[s];
}

/* Score of the samples of one placement, of all poses, or of one log; `rows` stays 0 without
 * samples. */
static mukca_score score_part(mukca_score score, const mukca_evaluation *e,
                              const mukca_dataset *data)
{
    const int placement = score.placement;
    const double *error = e->error;
    score.distance_error = score.rotation_error = NAN;
    double sum = 0, squares = 0, angles = 0, distortion = 0;
    int rows = 0, turns = 0, pairs = 0;
    for (int i = 0; i < data->n_rows; i++) {
        if (mukca_dataset_placement(data, i) != placement) continue;
        if (score.file >= 0 &&
            (data->file[i] != score.file || mukca_dataset_target(data, i) != score.target))
            continue;
        const bool oriented =
            placement < 0 && data->quaternion && isfinite(data->quaternion[4 * i]);
        if (oriented) {
            double R[9];
            mukca_rotation_from_quaternion(R, data->quaternion + 4 * i);
            angles += mukca_rotation_between(e->tips[i].R, R);
            turns++;
        }
        if (isfinite(error[i])) sum += error[i], squares += error[i] * error[i], rows++;
        score.rows += oriented || isfinite(error[i]);
    }
    for (int p = 0; p < data->n_distances; p++) {
        const mukca_distance *d = &data->distances[p];
        if (data->sockets[d->a].placement != placement || !e->count[d->a] || !e->count[d->b])
            continue;
        distortion += fabs(mukca_distance3(e->mean[d->a], e->mean[d->b]) - d->distance), pairs++;
    }
    score.mae = rows ? sum / rows : (double)NAN;
    score.std = rows ? sqrt(squares / rows) : (double)NAN;
    if (turns) score.rotation_error = angles / turns;
    if (pairs) score.distance_error = distortion / pairs;
    return score;
}

/* Mean of each field over the scores that have it. */
static mukca_score mean_score(const mukca_score *scores, int n)
{
    mukca_score mean = {.placement = -1, .file = -1, .target = -1};
    double *const field[4] = {&mean.mae, &mean.std, &mean.distance_error, &mean.rotation_error};
    int count[4] = {0};
    for (int i = 0; i < n; i++) {
        const mukca_score *s = &scores[i];
        const double value[4] = {s->mae, s->std, s->distance_error, s->rotation_error};
        mean.rows += s->rows;
        for (int f = 0; f < 4; f++)
            if (isfinite(value[f])) *field[f] += value[f], count[f]++;
    }
    for (int f = 0; f < 4; f++) *field[f] = count[f] ? *field[f] / count[f] : (double)NAN;
    return mean;
}

const double *mukca_evaluation_centre(const mukca_evaluation *e, const mukca_dataset *data, int row)
{
    return data->socket[row] >= 0 ? e->mean[data->socket[row]]
           : data->position       ? data->position + 3 * (size_t)row
                                  : NULL;
}

bool mukca_evaluation_make(mukca_evaluation *e, mukca_pool *pool, const mukca_model *model,
                           const mukca_dataset *data)
{
    e->tips = MUKCA_TAKE(pool, mukca_frame, data->n_rows);
    e->error = MUKCA_TAKE(pool, double, data->n_rows);
    e->mean = MUKCA_TAKE(pool, double[3], data->n_sockets);
    e->count = MUKCA_TAKE(pool, int, data->n_sockets);
    mukca_chain *arm = MUKCA_TAKE(pool, mukca_chain, 1);
    double(*sum)[4] = MUKCA_TAKE(pool, double[4], data->n_targets);
    if (pool->failed) return false;
    find_tips(e->tips, arm, model, data);
    place_tips(e->tips, sum, data);
    socket_means(e->mean, e->count, e->tips, data);
    for (int i = 0; i < data->n_rows; i++) {
        const double *about = mukca_evaluation_centre(e, data, i);
        e->error[i] = about ? mukca_distance3(e->tips[i].p, about) : (double)NAN;
    }
    return true;
}

bool mukca_evaluate_rows(double *error, const mukca_model *model, const mukca_dataset *data)
{
    mukca_evaluation e;
    mukca_pool pool = {0};
    const bool ok = mukca_evaluation_make(&e, &pool, model, data);
    if (ok) memcpy(error, e.error, (size_t)data->n_rows * sizeof *error);
    mukca_pool_free(&pool);
    return ok;
}

int mukca_evaluate(mukca_score *scores, mukca_score *mean, const mukca_model *model,
                   const mukca_dataset *data)
{
    mukca_evaluation e;
    mukca_pool pool = {0};
    const bool ok = mukca_evaluation_make(&e, &pool, model, data);
    int n = 0;
    for (int p = 0; p <= data->n_placements && ok; p++) {
        const bool poses = p == data->n_placements, logs = poses && model->by_log;
        for (int f = logs ? 0 : -1; f < (logs ? data->n_files : 0); f++)
            for (int t = -1; t < (logs ? data->n_targets : 0); t++) {
                scores[n] = score_part(
                    (mukca_score){.placement = poses ? -1 : p, .file = f, .target = t}, &e, data);
                n += scores[n].rows > 0;
            }
    }
    if (mean && ok) *mean = mean_score(scores, n);
    mukca_pool_free(&pool);
    return ok ? n : -1;
}

/* Samples whose predictions differ by less than the repeatability of a printed socket (0.1 to 0.2
 * mm) are of one posture and carry no information on sockets, m. */
static const double least_rms = 5e-5;

int mukca_coincide_drop(double *apart, mukca_dataset *data, const mukca_chain *chain,
                        const double *theta, int least)
{
    mukca_evaluation e;
    mukca_pool pool = {0};
    const mukca_model model = {.chain = chain, .theta = theta};
    if (!data->n_distances) return 0;
    double *squares = MUKCA_TAKE(&pool, double, data->n_sockets);
    mukca_distance *moved = MUKCA_TAKE(&pool, mukca_distance, data->n_distances);
    const bool ok = mukca_evaluation_make(&e, &pool, &model, data) && e.mean;
    int found = 0, kept = 0;
    for (int i = 0; i < data->n_rows && ok; i++)
        if (data->socket[i] >= 0) squares[data->socket[i]] += e.error[i] * e.error[i];
    for (int k = 0; k < data->n_distances && ok; k++) {
        const mukca_distance d = data->distances[k];
        const double rms = sqrt((squares[d.a] + squares[d.b]) / (e.count[d.a] + e.count[d.b])),
                     far = mukca_distance3(e.mean[d.a], e.mean[d.b]);
        const bool same = e.count[d.a] >= least && e.count[d.b] >= least &&
                          far < fmax(rms, 0.08 * d.distance) && rms > least_rms &&
                          rms < 0.25 * d.distance;
        if (same)
            moved[found] = d, apart[found++] = far;
        else
            data->distances[kept++] = d;
    }
    if (found) memcpy(data->distances + kept, moved, (size_t)found * sizeof *moved);
    if (ok) data->n_distances = kept;
    mukca_pool_free(&pool);
    return ok ? found : -1;
}
