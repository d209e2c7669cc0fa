/* Pose logs read row by row: read or refused, and the same rows when they are read again. */
#include <math.h>
#include <string.h>

#include "../unit/arms.h"
#include "io/pose_log.h"
#include "memory_file.h"

static void check_row(const mukca_pose_row *row)
{
    double square = 0;
    for (int i = 0; i < 4; i++) square += row->quaternion[i] * row->quaternion[i];
    for (int j = 0; j < 2; j++)
        if (!isfinite(row->q[j]) || isnan(row->velocity[j])) abort();
    for (int i = 0; i < 3; i++)
        if (!isfinite(row->position[i])) abort();
    if (fabs(square - 1) > 1e-9) abort(); /* NaN: none was measured */
}

/* Sum of the first angles of one reading. */
static double read_all(mukca_pose_log *log, mukca_error *error)
{
    const mukca_pose_row *row;
    double sum = 0;
    if (mukca_pose_log_rewind(log, error)) abort();
    for (long n = 0;; n++) {
        if (mukca_pose_log_next(&row, log, error)) abort();
        if (!row && n != log->n) abort();
        if (!row) return sum;
        check_row(row);
        sum += row->q[0];
    }
}

/* The options of reading, by the length of the input. */
static mukca_rows_format format_of(size_t size)
{
    static const char *const forms[] = {"XYZ",  "zyz",     "vector", "wxyz",
                                        "xyzw", "inverse", "none",   "xyz=ZXZ"};
    mukca_rows_format format = {.inverse = size / 16 % 4 == 3};
    if (size % 16 < 8 && !mukca_rotation_form_read(&format.rotation, forms[size % 16])) abort();
    return format;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_chain chain;
    mukca_error error = {MUKCA_OK, ""};
    const char *path = memory_file(bytes, size), *const paths[2] = {path, path};
    make_chain(&chain, "RR", NULL, "j", 3);
    const mukca_pose_files files = {
        .paths = paths, .n_paths = 2, .first_file = 1, .format = format_of(size)};
    mukca_pose_log log = {.n_joints = 2};
    if (mukca_pose_log_read(&log, &files, &chain, &error)) {
        if (!error.text[0] || strchr(error.text, '\n')) abort();
    } else {
        if (log.n % 2) abort();
        const double first = read_all(&log, &error), again = read_all(&log, &error);
        if (memcmp(&first, &again, sizeof first)) abort();
    }
    mukca_pose_log_close(&log);
    return 0;
}
