/* Pose logs from files, row by row, with a binary copy for further passes. */
#include "io/pose_stream.h"

#include <math.h>
#include <string.h>

#include "base/file.h"

static bool open_file(mukca_pose_stream *s, mukca_error *error)
{
    const mukca_rows_options options = {.kind = MUKCA_HEADER,
                                        .format = s->format,
                                        .any_order = true, /* mukca_pose_check detects the order */
                                        .note = s->noted ? NULL : s->note,
                                        .context = s->context};
    s->open = mukca_rows_open(&s->rows, s->paths[s->at], s->chain, &options, error) == MUKCA_OK;
    if (s->open && s->rows.column.n_measured == 0)
        mukca_rows_fail_measured(&s->rows,
                                 "no columns x_m, y_m, z_m; a pose log needs measured positions");
    return s->open;
}

/* Check that all rows measure one target. */
static void check_target(mukca_pose_stream *s, const mukca_row *row)
{
    const char *name = row->target ? row->target : "";
    const int column = s->rows.column.target;
    if (strlen(name) >= sizeof s->target)
        mukca_table_fail(&s->rows.table, column, "'%.20s...' is longer than 63 characters", name);
    if (!s->named) snprintf(s->target, sizeof s->target, "%s", name);
    s->named = true;
    if (strcmp(s->target, name) != 0)
        mukca_table_fail(&s->rows.table, column,
                         "a second target, '%.40s': mukca diagnose -o fits several", name);
}

/* Parse the next row; *more is false at the end of the last file. */
static mukca_status parse(mukca_pose_stream *s, mukca_pose_row *row, bool *more, mukca_error *error)
{
    mukca_row read = {.position = {(double)NAN}};
    mukca_status status = MUKCA_OK;
    while (status == MUKCA_OK && !isfinite(read.position[0])) {
        *more = s->at < s->n_paths;
        s->noted |= !*more;
        if (!*more) return MUKCA_OK;
        if (!s->open && !open_file(s, error)) return error->status;
        if (mukca_rows_next(&s->rows, &read)) {
            if (isfinite(read.position[0])) check_target(s, &read);
            status = s->rows.table.status;
        } else {
            status = mukca_rows_close(&s->rows);
            s->open = false;
            s->at++;
            read.position[0] = (double)NAN;
        }
    }
    if (status != MUKCA_OK) return status;
    memcpy(row->q, read.q, sizeof row->q);
    memcpy(row->velocity, read.velocity, sizeof row->velocity);
    memcpy(row->position, read.position, sizeof row->position);
    memcpy(row->quaternion, read.quaternion, sizeof row->quaternion);
    row->time = read.time;
    row->file = s->at;
    return MUKCA_OK;
}

static void stop_keeping(mukca_pose_stream *s)
{
    if (s->kept) fclose(s->kept);
    s->kept = NULL;
    s->full = true;
    s->n_kept = 0;
}

static void keep(mukca_pose_stream *s, const mukca_pose_row *row)
{
    if (!s->kept && (s->kept = tmpfile())) setvbuf(s->kept, s->buffer, _IOFBF, sizeof s->buffer);
    s->next = ++s->n_kept;
    if (!s->kept || (double)s->n_kept * sizeof *row > MUKCA_POSE_STREAM_KEPT ||
        fwrite(row, sizeof *row, 1, s->kept) != 1)
        stop_keeping(s);
}

static mukca_status fetch(mukca_pose_stream *s, mukca_pose_row *row, mukca_error *error)
{
    /* a stream changes from reading to writing only after a seek */
    if (fread(row, sizeof *row, 1, s->kept) == 1 &&
        (++s->next < s->n_kept || fseek(s->kept, 0, SEEK_END) == 0))
        return MUKCA_OK;
    return mukca_file_fail(error, "temporary file");
}

static mukca_status next(void *context, mukca_pose_row *row, bool *more, mukca_error *error)
{
    mukca_pose_stream *s = context;
    *more = true;
    if (s->next < s->n_kept) return fetch(s, row, error);
    const mukca_status status = parse(s, row, more, error);
    if (status == MUKCA_OK && *more && !s->full) keep(s, row);
    return status;
}

static mukca_status rewind_stream(void *context, mukca_error *error)
{
    mukca_pose_stream *s = context;
    (void)error;
    s->next = 0;
    /* the seek flushes the file and detects a full disk */
    if (s->kept && fseek(s->kept, 0, SEEK_SET) != 0) stop_keeping(s);
    if (s->kept) return MUKCA_OK;
    if (s->open) mukca_rows_close(&s->rows);
    s->open = false;
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
    if (stream->kept) fclose(stream->kept);
    stream->open = false;
    stream->kept = NULL;
    stream->n_kept = 0;
}
