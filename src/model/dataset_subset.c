/* Datasets: subsets, commanded angles, states of the joints. */
#include "model/dataset_subset.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Replace the list at `list` (NULL stays NULL) by a copy of its items with nonzero keep[], NULL:
 * all n; room for `kept`. */
static bool copy_items(void *list, size_t size, int n, const unsigned char *keep, int kept)
{
    char *from, *copy, *to;
    memcpy(&from, list, sizeof from);
    if (!from) return true;
    copy = to = calloc((size_t)kept + 1, size);
    for (int i = 0; i < n && copy; i++, from += size) {
        if (keep && !keep[i]) continue;
        memcpy(to, from, size);
        to += size;
    }
    memcpy(list, &copy, sizeof copy);
    return copy != NULL;
}

mukca_status mukca_dataset_subset(mukca_dataset *out, const mukca_dataset *data,
                                  const unsigned char *keep, mukca_error *error)
{
    mukca_dataset d = *data;
    const size_t one = sizeof(double), joints = (size_t)d.n_joints * one;
    const struct {
        void *list;
        size_t size;
    } of_rows[] = {{&d.q, joints},
                   {&d.socket, sizeof *d.socket},
                   {&d.row, sizeof *d.row},
                   {&d.file, sizeof *d.file},
                   {&d.target, sizeof *d.target},
                   {&d.time, one},
                   {&d.payload, one},
                   {&d.effort, joints},
                   {&d.command, joints},
                   {&d.reading, joints},
                   {&d.velocity, joints},
                   {&d.position, 3 * one},
                   {&d.quaternion, 4 * one}};
    bool good = true;
    d.n_rows = 0;
    for (int i = 0; i < data->n_rows; i++) d.n_rows += keep[i] != 0;
    for (size_t l = 0; l < sizeof of_rows / sizeof *of_rows; l++)
        good &= copy_items(of_rows[l].list, of_rows[l].size, data->n_rows, keep, d.n_rows);
    good &= copy_items(&d.sockets, sizeof *d.sockets, d.n_sockets, NULL, d.n_sockets);
    good &= copy_items(&d.placements, sizeof *d.placements, d.n_placements, NULL, d.n_placements);
    good &= copy_items(&d.distances, sizeof *d.distances, d.n_distances, NULL, d.n_distances);
    good &= copy_items(&d.files, sizeof *d.files, d.n_files, NULL, d.n_files);
    good &= copy_items(&d.targets, sizeof *d.targets, d.n_targets, NULL, d.n_targets);
    *out = d;
    if (good) return MUKCA_OK;
    mukca_dataset_free(out);
    return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", d.n_rows);
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
