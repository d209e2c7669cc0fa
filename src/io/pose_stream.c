/* Pose logs from files, row by row. */
#include "io/pose_stream.h"

#include <math.h>
#include <string.h>

static mukca_status open_file(mukca_pose_stream *s, mukca_error *error)
{
    const mukca_rows_options options = {.kind = MUKCA_HEADER,
                                        .format = s->format,
                                        .note = s->noted ? NULL : s->note,
                                        .context = s->context};
    const mukca_status status =
        mukca_rows_open(&s->rows, s->paths[s->at], s->chain, &options, error);
    if (status != MUKCA_OK) return status;
    s->open = true;
    if (s->rows.column.n_measured > 0) return MUKCA_OK;
    return mukca_table_fail(error, &s->rows.table, -1,
                            "no columns x_m, y_m, z_m; a pose log needs measured positions");
}

/* All rows are of one target. */
static mukca_status check_target(mukca_pose_stream *s, const mukca_row *row, mukca_error *error)
{
    const char *name = row->target ? row->target : "";
    if (!s->named) snprintf(s->target, sizeof s->target, "%s", name);
    s->named = true;
    if (strncmp(s->target, name, sizeof s->target - 1) == 0) return MUKCA_OK;
    return mukca_table_fail(error, &s->rows.table, s->rows.column.target,
                            "a second target, '%.40s': mukca diagnose -o fits several", name);
}

static mukca_status next(void *context, mukca_pose_row *row, bool *more, mukca_error *error)
{
    mukca_pose_stream *s = context;
    mukca_row read;
    bool found = false;
    do {
        mukca_status status = MUKCA_OK;
        *more = s->at < s->n_paths;
        s->noted |= !*more;
        if (!*more) return MUKCA_OK;
        if (!s->open) status = open_file(s, error);
        if (status == MUKCA_OK) status = mukca_rows_next(&s->rows, &read, &found, error);
        if (status != MUKCA_OK) return status;
        if (found) status = check_target(s, &read, error);
        if (status != MUKCA_OK) return status;
        if (!found) {
            mukca_pose_stream_close(s);
            s->at++;
        }
    } while (!found || !isfinite(read.position[0]));
    memcpy(row->q, read.q, sizeof row->q);
    memcpy(row->velocity, read.velocity, sizeof row->velocity);
    memcpy(row->position, read.position, sizeof row->position);
    memcpy(row->quaternion, read.quaternion, sizeof row->quaternion);
    row->time = read.time;
    row->file = s->at;
    return MUKCA_OK;
}

static mukca_status rewind_stream(void *context, mukca_error *error)
{
    mukca_pose_stream *s = context;
    (void)error;
    mukca_pose_stream_close(s);
    s->at = 0;
    return MUKCA_OK;
}

void mukca_pose_stream_start(mukca_pose_log *log, mukca_pose_stream *stream)
{
    *log = (mukca_pose_log){.next = next, .rewind = rewind_stream, .context = stream};
}

void mukca_pose_stream_close(mukca_pose_stream *stream)
{
    if (stream->open) mukca_rows_close(&stream->rows);
    stream->open = false;
}
