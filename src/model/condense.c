/* Condensing of recordings with too many rows for a diagnosis: one sample per posture. */
#include "model/condense.h"

#include <math.h>
#include <stdlib.h>

#include "model/dataset_subset.h"

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
    for (int j = 0; j < d->n_joints; j++)
        if (!(fabs(b[j] - a[j]) <= STILL)) return false;
    return true;
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
    const int n = d->n_joints;
    if (count < 2) return;
    average(d->q, n, first, count);
    average(d->time, 1, first, count);
    average(d->effort, n, first, count);
    average(d->command, n, first, count);
    average(d->reading, n, first, count);
    average(d->velocity, n, first, count);
    average(d->position, 3, first, count);
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
    mukca_dataset kept;
    const mukca_status status = mukca_dataset_subset(&kept, data, keep, error);
    free(keep);
    if (status != MUKCA_OK) return status;
    mukca_dataset_free(data);
    *data = kept;
    return MUKCA_OK;
}
