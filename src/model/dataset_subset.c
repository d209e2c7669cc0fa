/* Datasets: subsets, commanded angles, states of the joints. */
#include "model/dataset_subset.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Copy the kept samples of source[rows][width]; NULL stays NULL. */
static bool copy_doubles(double **out, const double *source, int width, const mukca_dataset *data,
                         const unsigned char *keep, int kept)
{
    *out = NULL;
    if (!source) return true;
    size_t size = (size_t)width;
    double *to = *out = calloc((size_t)kept * size + 1, sizeof *to);
    if (!to) return false;
    for (int i = 0; i < data->n_rows; i++) {
        if (!keep[i]) continue;
        memcpy(to, source + (size_t)i * size, size * sizeof *to);
        to += size;
    }
    return true;
}

/* Copy a list of `count` items; NULL stays NULL. */
static bool copy_list(void *out_pointer, const void *source, int count, size_t size)
{
    void *copy = NULL;
    if (source) {
        copy = calloc((size_t)count + 1, size);
        if (!copy) return false;
        memcpy(copy, source, (size_t)count * size);
    }
    memcpy(out_pointer, &copy, sizeof copy);
    return true;
}

mukca_status mukca_dataset_subset(mukca_dataset *out, const mukca_dataset *data,
                                  const unsigned char *keep, mukca_error *error)
{
    int kept = 0;
    for (int i = 0; i < data->n_rows; i++) kept += keep[i] != 0;
    mukca_dataset copy;
    mukca_status status = mukca_dataset_create(&copy, kept, data->n_joints, data->n_sockets,
                                               data->n_placements, error);
    if (status) return status;
    if (data->sockets)
        memcpy(copy.sockets, data->sockets, (size_t)data->n_sockets * sizeof *copy.sockets);
    if (data->placements)
        memcpy(copy.placements, data->placements,
               (size_t)data->n_placements * sizeof *copy.placements);
    copy.n_distances = data->n_distances;
    copy.n_files = data->n_files;
    copy.n_targets = data->n_targets;
    copy.by_command = data->by_command;
    double *q = NULL;
    const int n = data->n_joints;
    bool good =
        copy_doubles(&q, data->q, n, data, keep, kept) &&
        copy_doubles(&copy.time, data->time, 1, data, keep, kept) &&
        copy_doubles(&copy.temperature, data->temperature, 1, data, keep, kept) &&
        copy_doubles(&copy.payload, data->payload, 1, data, keep, kept) &&
        copy_doubles(&copy.effort, data->effort, n, data, keep, kept) &&
        copy_doubles(&copy.command, data->command, n, data, keep, kept) &&
        copy_doubles(&copy.reading, data->reading, n, data, keep, kept) &&
        copy_doubles(&copy.velocity, data->velocity, n, data, keep, kept) &&
        copy_doubles(&copy.position, data->position, 3, data, keep, kept) &&
        copy_doubles(&copy.quaternion, data->quaternion, 4, data, keep, kept) &&
        copy_list(&copy.distances, data->distances, data->n_distances, sizeof *data->distances) &&
        copy_list(&copy.files, data->files, data->n_files, sizeof *data->files) &&
        copy_list(&copy.targets, data->targets, data->n_targets, sizeof *data->targets) &&
        copy_list(&copy.target, data->target, data->n_rows, sizeof *data->target);
    if (q) {
        free(copy.q);
        copy.q = q;
    }
    if (!good) {
        mukca_dataset_free(&copy);
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", kept);
    }
    for (int i = 0, k = 0; i < data->n_rows; i++) {
        if (!keep[i]) continue;
        copy.socket[k] = data->socket[i];
        copy.row[k] = data->row[i];
        copy.file[k] = data->file[i];
        if (copy.target) copy.target[k] = data->target[i];
        k++;
    }
    *out = copy;
    return MUKCA_OK;
}

mukca_status mukca_dataset_take_commands(mukca_dataset *data, mukca_error *error)
{
    const size_t count = (size_t)data->n_rows * (size_t)data->n_joints;
    data->by_command = true;
    if (!data->command || data->reading) return MUKCA_OK;
    double *q = calloc(count + 1, sizeof *q);
    if (!q) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", data->n_rows);
    for (size_t i = 0; i < count; i++)
        q[i] = isnan(data->command[i]) ? data->q[i] : data->command[i];
    data->reading = data->q;
    data->q = q;
    return MUKCA_OK;
}

const mukca_joint_state *mukca_dataset_state(mukca_row_state *rows, const mukca_dataset *data,
                                             int row)
{
    const size_t at = (size_t)row * (size_t)data->n_joints;
    const mukca_row_reading reading = {.q = data->q + at,
                                       .command = data->command ? data->command + at : NULL,
                                       .time = data->time ? data->time[row] : (double)NAN,
                                       .payload_kg = data->payload ? data->payload[row] : 0,
                                       .placement = mukca_dataset_placement(data, row),
                                       .number = data->row[row]};
    if (row == 0 || data->file[row] != data->file[row - 1])
        mukca_row_state_start(rows, data->n_joints);
    return mukca_row_state_next(rows, &reading);
}

/* Mark the part; false: out of memory. */
static bool mark_part(unsigned char *keep, const mukca_dataset *data, int most)
{
    int groups = 0;
    const size_t places = (size_t)data->n_placements + 1, sockets = (size_t)data->n_sockets + 1;
    int *rows = calloc(places + sockets, sizeof *rows);
    if (!rows) return false;
    int *seen = rows + places; /* samples so far of the poses, then of each socket */
    for (int i = 0; i < data->n_rows; i++) rows[mukca_dataset_placement(data, i) + 1]++;
    for (size_t g = 0; g < places; g++) groups += rows[g] > 0;
    for (int i = 0; i < data->n_rows; i++) {
        const long long in_group = rows[mukca_dataset_placement(data, i) + 1];
        const int every = (int)((in_group * groups + most - 1) / most);
        keep[i] = seen[data->socket[i] + 1]++ % every == 0;
    }
    free(rows);
    return true;
}

mukca_status mukca_part_take(mukca_dataset *part, const mukca_dataset *data, int most,
                             mukca_error *error)
{
    unsigned char *keep = malloc((size_t)data->n_rows + 1);
    const bool marked = keep && mark_part(keep, data, most);
    const mukca_status status = marked ? mukca_dataset_subset(part, data, keep, error)
                                       : mukca_fail(error, MUKCA_MEMORY, "out of memory");
    free(keep);
    return status;
}
