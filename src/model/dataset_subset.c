/* Datasets: columns, subsets, commanded angles, states of the joints. */
#include "model/dataset_subset.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const mukca_column mukca_column_table[] = {
#define ROW(constant, member, width, of, decimals, ...) {width, of, decimals, {__VA_ARGS__}},
    MUKCA_COLUMN_LIST(ROW)
#undef ROW
};

/* Replace the list at `list` (NULL stays NULL) by a copy of its items with nonzero keep[], NULL:
 * all n; room for `kept`. */
static bool copy_items(void *list, size_t size, int n, const unsigned char *keep, int kept)
{
    char *from;
    memcpy(&from, list, sizeof from);
    if (!from) return true;
    char *to = calloc((size_t)kept + 1, size);
    memcpy(list, &to, sizeof to);
    if (!to) return false;
    for (int i = 0; i < n; i++, from += size) {
        if (keep && !keep[i]) continue;
        memcpy(to, from, size);
        to += size;
    }
    return true;
}

mukca_status mukca_dataset_subset(mukca_dataset *out, const mukca_dataset *data,
                                  const unsigned char *keep, mukca_error *error)
{
    mukca_dataset d = *data;
    const int n = data->n_rows;
    int **const indices[] = {&d.socket, &d.row, &d.file, &d.target};
    bool good = true;
    d.n_rows = 0;
    for (int i = 0; i < n; i++) d.n_rows += keep[i] != 0;
    for (int i = 0; i < 4; i++)
        good &= copy_items(indices[i], sizeof **indices[i], n, keep, d.n_rows);
    for (int c = 0; c < MUKCA_COLUMNS; c++)
        good &= copy_items(&d.column[c], (size_t)mukca_column_width(c, d.n_joints) * sizeof *d.q, n,
                           keep, d.n_rows);
    good &= copy_items(&d.reading, (size_t)d.n_joints * sizeof *d.q, n, keep, d.n_rows);
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

mukca_status mukca_dataset_reduce(mukca_dataset *data, const unsigned char *keep,
                                  mukca_error *error)
{
    mukca_dataset kept;
    const mukca_status status = mukca_dataset_subset(&kept, data, keep, error);
    if (status == MUKCA_OK) mukca_dataset_free(data), *data = kept;
    return status;
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

mukca_status mukca_part_take(mukca_dataset *part, const mukca_dataset *data, int most,
                             mukca_error *error)
{
    mukca_pool pool = {0};
    int *rows = MUKCA_TAKE(&pool, int, data->n_placements + 1), groups = 0;
    int *seen = MUKCA_TAKE(&pool, int, data->n_sockets + 1); /* so far of poses, of each socket */
    unsigned char *keep = MUKCA_TAKE(&pool, unsigned char, data->n_rows);
    const int n = pool.failed ? 0 : data->n_rows;
    for (int i = 0; i < n; i++) groups += rows[mukca_dataset_placement(data, i) + 1]++ == 0;
    for (int i = 0; i < n; i++) {
        const long long in_group = rows[mukca_dataset_placement(data, i) + 1];
        const int every = (int)((in_group * groups + most - 1) / most);
        keep[i] = seen[data->socket[i] + 1]++ % every == 0;
    }
    const mukca_status status = pool.failed ? mukca_fail(error, MUKCA_MEMORY, "out of memory")
                                            : mukca_dataset_subset(part, data, keep, error);
    mukca_pool_free(&pool);
    return status;
}

/* ---- one sample per posture of a recording with too many rows for a diagnosis ---- */

/* Largest difference of angles within a posture, rad: several steps of any encoder. */
#define STILL 2e-4
/* Successive postures kept together: last moves and the autocorrelation of the noise are preserved
 * except at the first of each block. */
enum { BLOCK = 50 };

/* Does a row belong to the posture of row `first`? */
static bool same_posture(const mukca_dataset *d, int first, int row)
{
    const double *a = d->q + (size_t)first * (size_t)d->n_joints,
                 *b = d->q + (size_t)row * (size_t)d->n_joints;
    if (d->file[row] != d->file[first] || d->socket[row] != d->socket[first] ||
        mukca_dataset_target(d, row) != mukca_dataset_target(d, first))
        return false;
    if (d->payload && d->payload[row] != d->payload[first] &&
        !(isnan(d->payload[row]) && isnan(d->payload[first])))
        return false;
    return mukca_largest_difference(a, b, d->n_joints) <= STILL;
}

/* x[n_rows][columns] (NULL: none): replace row `first` by the mean of `count` rows starting there.
 */
static void average(double *x, int columns, int first, int count)
{
    if (!x) return;
    x += (size_t)first * (size_t)columns;
    for (int c = 0; c < columns; c++) {
        double sum = 0;
        for (int i = 0; i < count; i++) sum += x[i * columns + c];
        x[c] = sum / count;
    }
}

/* Equivalent quaternions may differ in sign. */
static void average_quaternions(double *q, int first, int count)
{
    if (!q) return;
    double sum[4] = {0}, length = 0;
    q += 4 * (size_t)first;
    for (int i = 0; i < count; i++) {
        double dot = 0;
        for (int c = 0; c < 4; c++) dot += q[4 * i + c] * q[c];
        for (int c = 0; c < 4; c++) sum[c] += dot < 0 ? -q[4 * i + c] : q[4 * i + c];
    }
    for (int c = 0; c < 4; c++) length += sum[c] * sum[c];
    for (int c = 0; c < 4; c++) q[c] = sum[c] / sqrt(length);
}

static void average_rows(mukca_dataset *d, int first, int count)
{
    if (count < 2) return;
    for (int c = 0; c < MUKCA_COLUMNS; c++)
        if (c != MUKCA_COLUMN_PAYLOAD && c != MUKCA_COLUMN_QUATERNION) /* equal; see above */
            average(d->column[c], mukca_column_width(c, d->n_joints), first, count);
    average(d->reading, d->n_joints, first, count);
    average_quaternions(d->quaternion, first, count);
}

/* Mark the first row of each posture in keep[n_rows] and replace it by the mean; returns the number
 * of postures. */
static int find_postures(unsigned char *keep, mukca_dataset *d)
{
    int postures = 0;
    for (int row = 0, count; row < d->n_rows; row += count) {
        for (count = 1; row + count < d->n_rows && same_posture(d, row, row + count);) count++;
        average_rows(d, row, count);
        keep[row] = 1;
        postures++;
    }
    return postures;
}

/* Unmark evenly spaced blocks until at most `most` postures remain; returns their number. */
static int spread(unsigned char *keep, int n_rows, int postures, int most)
{
    const long long blocks = (postures + BLOCK - 1) / BLOCK,
                    wanted = most < BLOCK ? 1 : most / BLOCK;
    int left = 0;
    for (int row = 0, posture = 0; row < n_rows; row++) {
        if (!keep[row]) continue;
        const long long b = posture++ / BLOCK;
        keep[row] = (b + 1) * wanted / blocks > b * wanted / blocks;
        left += keep[row];
    }
    return left;
}

mukca_status mukca_condense(mukca_condensed *how, mukca_dataset *data, int most, mukca_error *error)
{
    *how = (mukca_condensed){data->n_rows, data->n_rows, data->n_rows};
    if (data->n_rows <= most) return MUKCA_OK;
    unsigned char *keep = calloc((size_t)data->n_rows, 1);
    if (!keep) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", data->n_rows);
    how->samples = how->postures = find_postures(keep, data);
    if (how->postures > most) how->samples = spread(keep, data->n_rows, how->postures, most);
    const mukca_status status = mukca_dataset_reduce(data, keep, error);
    free(keep);
    return status;
}
