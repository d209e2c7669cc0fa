/* Pose logs: rows with velocities in a temporary file. */
#include <errno.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "recalibrate/recalibrate.h"

/* Whether two rows are consecutive in a motion. */
static bool adjacent(const mukca_pose_row *a, const mukca_pose_row *b, int n_joints)
{
    if (a->file != b->file) return false;
    if ((isfinite(a->time) || isfinite(b->time)) && !(a->time < b->time)) return false;
    for (int j = 0; j < n_joints; j++)
        if (!(fabs(a->q[j] - b->q[j]) < 0.2)) return false;
    return true;
}

static void fill_velocity(mukca_pose_row *now, const mukca_pose_row *before,
                          const mukca_pose_row *after, int n_joints)
{
    bool known = true;
    for (int j = 0; j < n_joints; j++) known &= isfinite(now->velocity[j]) != 0;
    if (known) return;
    const mukca_pose_row *from = adjacent(before, now, n_joints) ? before : now,
                         *to = adjacent(now, after, n_joints) ? after : now;
    const int rows = (to != now) + (from != now);
    const double span = isfinite(now->time) ? to->time - from->time : rows;
    for (int j = 0; j < n_joints; j++) now->velocity[j] = rows ? (to->q[j] - from->q[j]) / span : 0;
}

static mukca_status fail(mukca_error *error)
{
    return mukca_fail(
        error, MUKCA_MEMORY,
        "the temporary file of the pose log: %s; free about the size of the log in " P_tmpdir,
        strerror(errno));
}

/* Store the last row, which `after` follows. */
static bool store(mukca_pose_log *log, const mukca_pose_row *after)
{
    mukca_pose_row *now = &log->last[1];
    const size_t n = (size_t)log->n_joints, size = offsetof(mukca_pose_row, q) + n * sizeof *now->q;
    fill_velocity(now, &log->last[0], after, log->n_joints);
    return fwrite(now, size, 1, log->stream) == 1 &&
           fwrite(now->velocity, sizeof *now->q, n, log->stream) == n;
}

mukca_status mukca_pose_log_add(mukca_pose_log *log, const mukca_pose_row *row, mukca_error *error)
{
    if (!log->stream && !(log->stream = tmpfile())) return fail(error);
    const bool first = log->n == 0, oriented = isfinite(row->quaternion[0]);
    if (!first && !store(log, row)) return fail(error);
    for (int j = 0; j < log->n_joints; j++) {
        if (first || row->q[j] < log->lowest[j]) log->lowest[j] = row->q[j];
        if (first || row->q[j] > log->highest[j]) log->highest[j] = row->q[j];
    }
    if (first) log->oriented = oriented, log->timed = isfinite(row->time);
    log->n_oriented += oriented;
    log->n++;
    log->last[0] = log->last[1];
    log->last[1] = *row;
    return MUKCA_OK;
}

mukca_status mukca_pose_log_add_data(mukca_pose_log *log, const mukca_dataset *d,
                                     mukca_error *error)
{
    mukca_status status = MUKCA_OK;
    const size_t n = (size_t)d->n_joints;
    for (size_t i = 0; i < (size_t)d->n_rows && d->position && status == MUKCA_OK; i++) {
        if (!isfinite(d->position[3 * i])) continue;
        /* Sockets are recorded one by one: each is a file, as no motion connects them. */
        const int file = d->socket[i] < 0 ? d->file[i] : d->n_files + d->socket[i];
        mukca_pose_row row = {.quaternion = {(double)NAN},
                              .time = d->time ? d->time[i] : (double)NAN,
                              .velocity = {(double)NAN},
                              .file = 1 + file};
        memcpy(row.position, d->position + 3 * i, sizeof row.position);
        if (d->quaternion) memcpy(row.quaternion, d->quaternion + 4 * i, sizeof row.quaternion);
        memcpy(row.q, d->q + n * i, n * sizeof *row.q);
        if (d->velocity) memcpy(row.velocity, d->velocity + n * i, n * sizeof *row.q);
        status = mukca_pose_log_add(log, &row, error);
    }
    return status;
}

mukca_status mukca_pose_log_rewind(mukca_pose_log *log, mukca_error *error)
{
    const mukca_pose_row none = {.file = 0};
    if (log->last[1].file && !store(log, &none)) return fail(error);
    log->last[1].file = 0;
    log->at = 0;
    return !log->n || fseek(log->stream, 0, SEEK_SET) == 0 ? MUKCA_OK : fail(error);
}

mukca_status mukca_pose_log_next(const mukca_pose_row **row, mukca_pose_log *log,
                                 mukca_error *error)
{
    mukca_pose_row *now = &log->last[1];
    const size_t n = (size_t)log->n_joints, size = offsetof(mukca_pose_row, q) + n * sizeof *now->q;
    *row = log->at < log->n ? now : NULL;
    if (!*row) return MUKCA_OK;
    log->at++;
    errno = EIO; /* of a short read */
    return fread(now, size, 1, log->stream) == 1 &&
                   fread(now->velocity, sizeof *now->q, n, log->stream) == n
               ? MUKCA_OK
               : fail(error);
}

void mukca_pose_log_close(mukca_pose_log *log)
{
    if (log->stream) fclose(log->stream);
    *log = (mukca_pose_log){.n_joints = log->n_joints};
}
