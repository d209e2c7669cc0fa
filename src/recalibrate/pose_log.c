/* Pose logs: a dataset as a log, and a reader that adds velocities. */
#include "recalibrate/recalibrate.h"

#include <math.h>
#include <string.h>

static mukca_status cursor_next(void *context, mukca_pose_row *row, bool *more, mukca_error *error)
{
    mukca_pose_cursor *cursor = context;
    const mukca_dataset *d = cursor->data;
    (void)error;
    while (cursor->at < d->n_rows && !(d->position && isfinite(d->position[3 * cursor->at])))
        cursor->at++;
    *more = cursor->at < d->n_rows;
    if (!*more) return MUKCA_OK;
    const int i = cursor->at++, n = d->n_joints;
    for (int j = 0; j < n; j++) {
        row->q[j] = d->q[i * n + j];
        row->velocity[j] = d->velocity ? d->velocity[i * n + j] : (double)NAN;
    }
    memcpy(row->position, d->position + 3 * i, sizeof row->position);
    for (int a = 0; a < 4; a++)
        row->quaternion[a] = d->quaternion ? d->quaternion[4 * i + a] : (double)NAN;
    row->time = d->time ? d->time[i] : (double)NAN;
    /* Sockets are recorded one by one: treat each as a file, as no motion connects them. */
    row->file = d->socket[i] < 0 ? d->file[i] : d->n_files + d->socket[i];
    return MUKCA_OK;
}

static mukca_status cursor_rewind(void *context, mukca_error *error)
{
    (void)error;
    ((mukca_pose_cursor *)context)->at = 0;
    return MUKCA_OK;
}

void mukca_pose_log_from_dataset(mukca_pose_log *log, mukca_pose_cursor *cursor,
                                 const mukca_dataset *data)
{
    *cursor = (mukca_pose_cursor){.data = data};
    *log = (mukca_pose_log){.next = cursor_next, .rewind = cursor_rewind, .context = cursor};
}

/* Index in `row` and `state` of the preceding (0), present (1) or following (2) row. */
static int place(const mukca_pose_reader *r, int i)
{
    return (r->first + i) % 3;
}

/* Advance the window by one row. */
static mukca_status advance(mukca_pose_reader *r, mukca_error *error)
{
    r->first = place(r, 1);
    const int after = place(r, 2);
    r->state[after] = 0;
    for (; r->log < r->n_logs; r->log++, r->started = false) {
        const mukca_pose_log *log = &r->logs[r->log];
        mukca_status status = r->started ? MUKCA_OK : log->rewind(log->context, error);
        bool more = false;
        r->started = true;
        if (status == MUKCA_OK) status = log->next(log->context, &r->row[after], &more, error);
        if (more) r->state[after] = 1 + r->log;
        if (status != MUKCA_OK || more) return status;
    }
    return MUKCA_OK;
}

/* Whether the rows of the window at indices a and b are consecutive in a motion. */
static bool adjacent(const mukca_pose_reader *r, int a, int b)
{
    if (!r->state[a] || r->state[a] != r->state[b] || r->row[a].file != r->row[b].file)
        return false;
    if (isfinite(r->row[a].time) && !(r->row[a].time < r->row[b].time)) return false;
    for (int j = 0; j < r->n_joints; j++)
        if (!(fabs(r->row[a].q[j] - r->row[b].q[j]) < 0.2)) return false;
    return true;
}

static void fill_velocity(mukca_pose_reader *r)
{
    const int before = place(r, 0), at = place(r, 1), after = place(r, 2);
    mukca_pose_row *now = &r->row[at];
    if (isfinite(now->velocity[0])) return;
    const int from = adjacent(r, before, at) ? before : at,
              to = adjacent(r, at, after) ? after : at;
    const int rows = (to != at) + (from != at);
    const double span = isfinite(now->time) ? r->row[to].time - r->row[from].time : rows;
    for (int j = 0; j < r->n_joints; j++)
        now->velocity[j] = from == to ? 0 : (r->row[to].q[j] - r->row[from].q[j]) / span;
}

mukca_status mukca_pose_reader_next(mukca_pose_reader *r, mukca_error *error)
{
    const bool first = !r->started && r->log == 0;
    mukca_status status = first ? advance(r, error) : MUKCA_OK;
    if (status == MUKCA_OK) status = advance(r, error);
    const int at = place(r, 1);
    r->now = r->state[at] ? &r->row[at] : NULL;
    if (status != MUKCA_OK || !r->now) return status;
    fill_velocity(r);
    return MUKCA_OK;
}
