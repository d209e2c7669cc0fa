/* Pose logs: samples with a measured position, and the velocities of their joints. */
#include <stdlib.h>

#include "model/dataset_subset.h"
#include "recalibrate/recalibrate.h"

/* Whether two rows are consecutive in a motion.  Sockets are recorded one by one. */
static bool adjacent(const mukca_dataset *d, int a, int b)
{
    const double *p = d->q + (size_t)a * (size_t)d->n_joints,
                 *q = d->q + (size_t)b * (size_t)d->n_joints;
    if (a < 0 || b == d->n_rows || d->socket[a] != d->socket[b]) return false;
    if (d->socket[a] < 0 && d->file[a] != d->file[b]) return false;
    if (d->time && (isfinite(d->time[a]) || isfinite(d->time[b])) && !(d->time[a] < d->time[b]))
        return false;
    for (int j = 0; j < d->n_joints; j++)
        if (!(fabs(p[j] - q[j]) < 0.2)) return false;
    return true;
}

static void fill_velocity(mukca_dataset *d, int row)
{
    const size_t n = (size_t)d->n_joints;
    double *velocity = d->velocity + (size_t)row * n;
    bool known = true;
    for (size_t j = 0; j < n; j++) known &= isfinite(velocity[j]) != 0;
    if (known) return;
    const int from = row - adjacent(d, row - 1, row), to = row + adjacent(d, row, row + 1);
    const bool timed = d->time && isfinite(d->time[row]);
    const double span = timed ? d->time[to] - d->time[from] : to - from,
                 *p = d->q + (size_t)from * n, *q = d->q + (size_t)to * n;
    for (size_t j = 0; j < n; j++) velocity[j] = to > from ? (q[j] - p[j]) / span : 0;
}

static mukca_status keep_measured(mukca_dataset *d, mukca_error *error)
{
    unsigned char *keep = calloc((size_t)d->n_rows + 1, 1);
    int n = 0;
    if (!keep) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the pose log");
    for (int i = 0; i < d->n_rows; i++)
        n += keep[i] = d->position && isfinite(d->position[3 * (size_t)i]);
    const mukca_status status = n < d->n_rows ? mukca_dataset_reduce(d, keep, error) : MUKCA_OK;
    free(keep);
    return status;
}

mukca_status mukca_pose_log_prepare(mukca_dataset *d, mukca_error *error)
{
    MUKCA_TRY(keep_measured(d, error));
    const size_t count = (size_t)d->n_rows * (size_t)d->n_joints;
    if (!d->velocity) {
        d->velocity = malloc((count + 1) * sizeof *d->velocity);
        if (!d->velocity) return mukca_fail(error, MUKCA_MEMORY, "out of memory for velocities");
        for (size_t i = 0; i < count; i++) d->velocity[i] = (double)NAN;
    }
    for (int i = 0; i < d->n_rows; i++) fill_velocity(d, i);
    for (int i = 0; i < d->n_rows; i++) d->socket[i] = -1;
    d->n_sockets = d->n_placements = d->n_distances = 0;
    return MUKCA_OK;
}

void mukca_pose_log_shift(mukca_dataset *d, double lag)
{
    const size_t count = (size_t)d->n_rows * (size_t)d->n_joints;
    for (size_t i = 0; i < count; i++) d->q[i] += lag * d->velocity[i];
}
