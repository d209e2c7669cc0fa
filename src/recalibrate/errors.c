/* Statistics of pose errors, and a log without outliers. */
#include <stdlib.h>

#include "math/stats.h"
#include "model/dataset_subset.h"
#include "recalibrate/errors.h"

/* Vector lengths beyond so many medians, the length of 3 normals being 1.54 sigma: 8 sigma. */
static const double outlying = 8 / 1.54;

/* Lengths kept for medians, evenly spread, which determine it to 1 %. */
enum { KEPT = 8192 };

/* Measured minus predicted position, m; log of predicted' measured, rad; NaN: not measured. */
typedef struct {
    double position[3], rotation[3];
} pose_error;

static void find_error(pose_error *e, const mukca_geometry *g, const mukca_dataset *log, int row)
{
    const size_t i = (size_t)row;
    double measured[9], off[9];
    mukca_frame tip;
    mukca_fk_pose(&tip, g, log->q + i * (size_t)log->n_joints, NULL);
    for (int a = 0; a < 3; a++) {
        e->position[a] = log->position[3 * i + (size_t)a] - tip.p[a];
        e->rotation[a] = (double)NAN;
    }
    if (!mukca_pose_oriented(log, row)) return;
    mukca_rotation_from_quaternion(measured, log->quaternion + 4 * i);
    mukca_mat3_tmul(off, tip.R, measured);
    mukca_rotation_log(e->rotation, off);
}

/* Welford's algorithm. */
static void moments_add(mukca_moments *m, double x)
{
    m->n++;
    if (!(x <= m->max)) m->max = x;
    const double step = x - m->mean;
    m->mean += step / (double)m->n;
    m->m2 += step * (x - m->mean);
}

double mukca_moments_std(const mukca_moments *moments)
{
    return moments->n > 1 ? sqrt(moments->m2 / (double)(moments->n - 1)) : 0;
}

/* Add an error; the lengths of every `every`-th are kept. */
static void add_error(mukca_vector_errors *errors, double kept[KEPT], long every,
                      const double vector[3])
{
    if (!isfinite(vector[0])) return;
    const double length = mukca_norm3(vector);
    if (errors->length.n % every == 0) kept[errors->length.n / every] = length;
    moments_add(&errors->length, length);
    for (int a = 0; a < 3; a++) moments_add(&errors->axis[a], fabs(vector[a]));
}

mukca_status mukca_pose_errors_find(mukca_pose_errors *errors, const mukca_geometry *g,
                                    const mukca_dataset *log, mukca_error *error)
{
    const long every = 1 + log->n_rows / KEPT;
    double(*kept)[KEPT] = malloc(2 * sizeof *kept);
    mukca_vector_errors *both[2] = {&errors->position, &errors->rotation};
    *errors = (mukca_pose_errors){.position.median = 0};
    if (!kept) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the pose errors");
    for (int i = 0; i < log->n_rows; i++) {
        pose_error e;
        find_error(&e, g, log, i);
        for (int k = 0; k < 2; k++) add_error(both[k], kept[k], every, k ? e.rotation : e.position);
    }
    for (int k = 0; k < 2; k++)
        both[k]->median =
            mukca_stats_median(kept[k], (int)((both[k]->length.n + every - 1) / every));
    free(kept);
    return MUKCA_OK;
}

mukca_status mukca_pose_log_trim(mukca_dataset *kept, const mukca_geometry *g,
                                 const mukca_pose_errors *errors, const mukca_dataset *log,
                                 mukca_error *error)
{
    unsigned char *keep = malloc((size_t)log->n_rows + 1);
    if (!keep) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the pose log");
    for (int i = 0; i < log->n_rows; i++) {
        pose_error e;
        find_error(&e, g, log, i);
        keep[i] = mukca_norm3(e.position) <= outlying * errors->position.median &&
                  !(mukca_norm3(e.rotation) > outlying * errors->rotation.median);
    }
    const mukca_status status = mukca_dataset_subset(kept, log, keep, error);
    free(keep);
    return status;
}
