/* Pose logs from text files. */
#include "io/pose_log.h"

#include <math.h>
#include <string.h>

/* Check that all rows measure the target of the first one. */
static void check_target(char target[MUKCA_NAME_SIZE], bool first, mukca_rows *rows,
                         const mukca_row *row)
{
    const char *name = row->target ? row->target : "";
    if (strlen(name) >= MUKCA_NAME_SIZE)
        mukca_table_fail(&rows->table, rows->column.target,
                         "'%.20s...' is longer than 63 characters", name);
    if (first) snprintf(target, MUKCA_NAME_SIZE, "%s", name);
    if (strcmp(target, name) != 0)
        mukca_table_fail(&rows->table, rows->column.target,
                         "a second target, '%.40s': mukca diagnose -o fits several", name);
}

static mukca_status add(mukca_pose_log *log, const mukca_row *read, int file, mukca_error *error)
{
    mukca_pose_row row = {.time = read->time[0], .file = file};
    memcpy(row.position, read->position, sizeof row.position);
    memcpy(row.quaternion, read->quaternion, sizeof row.quaternion);
    memcpy(row.q, read->q, sizeof row.q);
    memcpy(row.velocity, read->velocity, sizeof row.velocity);
    return mukca_pose_log_add(log, &row, error);
}

mukca_status mukca_pose_log_read(mukca_pose_log *log, const mukca_pose_files *files,
                                 const mukca_chain *chain, mukca_error *error)
{
    const mukca_rows_options options = {.kind = MUKCA_HEADER,
                                        .format = files->format,
                                        .note = files->note,
                                        .context = files->context};
    const long before = log->n;
    char target[MUKCA_NAME_SIZE];
    mukca_status status = MUKCA_OK;
    for (int i = 0; i < files->n_paths && status == MUKCA_OK; i++) {
        mukca_rows rows;
        mukca_row row;
        status = mukca_rows_open(&rows, files->paths[i], chain, &options, error);
        if (status != MUKCA_OK) return status;
        if (rows.column.n_measured == 0)
            mukca_rows_fail_measured(
                &rows, "no columns x_m, y_m, z_m; a pose log needs measured positions");
        while (status == MUKCA_OK && mukca_rows_next(&rows, &row)) {
            if (files->stop && files->stop())
                status = mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
            if (!isfinite(row.position[0])) continue;
            check_target(target, log->n == before, &rows, &row);
            if (status == MUKCA_OK && rows.table.status == MUKCA_OK)
                status = add(log, &row, files->first_file + i, error);
        }
        const mukca_status closed = mukca_rows_close(&rows);
        if (status == MUKCA_OK) status = closed;
    }
    return status;
}
