/* Pose logs read row by row: read or refused, and the same rows when they are read again. */
#include <math.h>
#include <string.h>

#include "../unit/arms.h"
#include "io/pose_stream.h"
#include "memory_file.h"

static void check_row(const mukca_pose_row *row)
{
    double square = 0;
    for (int i = 0; i < 4; i++) square += row->quaternion[i] * row->quaternion[i];
    if (!isfinite(row->q[0]) || !isfinite(row->q[1]) || row->file < 0 || row->file > 1) abort();
    for (int i = 0; i < 3; i++)
        if (!isfinite(row->position[i])) abort();
    if (fabs(square - 1) > 1e-9) abort(); /* NaN: none was measured */
}

/* Rows of one reading; -1: refused. */
static int read_all(mukca_pose_log *log, double *sum, mukca_error *error)
{
    mukca_pose_row row;
    int n = 0;
    bool more = true;
    *sum = 0;
    if (log->rewind(log->context, error)) return -1;
    for (;;) {
        if (log->next(log->context, &row, &more, error)) return -1;
        if (!more) return n;
        check_row(&row);
        *sum += row.q[0];
        n++;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_chain chain;
    mukca_error error = {MUKCA_OK, ""};
    const char *path = memory_file(bytes, size), *const paths[2] = {path, path};
    make_chain(&chain, "RR", NULL, "j", 3);
    mukca_pose_stream stream = {.paths = paths, .n_paths = 2, .chain = &chain};
    mukca_pose_log log;
    double first, again;
    mukca_pose_stream_start(&log, &stream);
    int n = read_all(&log, &first, &error);
    if (n < 0 ? !error.text[0] || strchr(error.text, '\n') : n % 2) abort();
    if (n >= 0 && (read_all(&log, &again, &error) != n || memcmp(&first, &again, sizeof first)))
        abort();
    mukca_pose_stream_close(&stream);
    return 0;
}
