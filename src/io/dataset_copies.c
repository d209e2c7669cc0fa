/* Detection and removal of duplicate samples. */
#include "io/dataset.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/pool.h"
#include "model/dataset_subset.h"

/* Largest number of comparisons among samples of equal angles: bounds the time even for an arm at
 * rest for an hour. */
enum { MOST_COMPARED = 64 };

/* Whether the values agree; NaN agrees with everything. */
static bool agree(const double *a, int i, const double *b, int k, int width)
{
    for (int c = 0; a && b && c < width; c++) {
        const double one = a[i * width + c], other = b[k * width + c];
        if (!isnan(one) && !isnan(other) && one != other) return false;
    }
    return true;
}

static const char *label(const mukca_dataset *data, int row)
{
    return data->socket[row] < 0 ? "" : data->sockets[data->socket[row]].label;
}

/* Whether samples of equal joint angles agree in all else. */
static bool repeats(const mukca_dataset *a, int i, const mukca_dataset *b, int k)
{
    bool same = strcmp(label(a, i), label(b, k)) == 0;
    for (int c = 0; c < MUKCA_COLUMNS && same; c++)
        same = agree(a->column[c], i, b->column[c], k, mukca_column_width(c, a->n_joints));
    return same;
}

/* Bucket of a sample by its joint angles, bit by bit. */
static size_t bucket_of(const double *q, int n, int bits)
{
    return (size_t)(mukca_hash(MUKCA_HASH_START, q, (size_t)n * sizeof *q) >> (64 - bits));
}

/* original[n_rows]: index of the sample of `reference` (NULL: an earlier one of `data`) that each
 * sample repeats, or -1. */
static void find(int *original, mukca_pool *pool, const mukca_dataset *data,
                 const mukca_dataset *reference)
{
    const mukca_dataset *from = reference ? reference : data;
    const int n = data->n_joints;
    int bits = 1;
    while (bits < 30 && 1 << bits < from->n_rows) bits++;
    int *newest = MUKCA_TAKE(pool, int, (size_t)1 << bits); /* row + 1 of a bucket; 0: none */
    int *before = MUKCA_TAKE(pool, int, from->n_rows + 1);  /* likewise, by row + 1 */
    for (int i = 0; i < (reference ? reference->n_rows : 0) && !pool->failed; i++) {
        int *at = &newest[bucket_of(reference->q + (size_t)i * (size_t)n, n, bits)];
        before[i + 1] = *at;
        *at = i + 1;
    }
    for (int i = 0; i < data->n_rows && !pool->failed; i++) {
        const double *q = data->q + (size_t)i * (size_t)n;
        int *at = &newest[bucket_of(q, n, bits)], compared = 0;
        original[i] = -1;
        for (int k = *at; k && original[i] < 0 && compared < MOST_COMPARED; k = before[k]) {
            if (memcmp(from->q + (size_t)(k - 1) * (size_t)n, q, (size_t)n * sizeof *q) != 0)
                continue;
            compared++;
            if (repeats(data, i, from, k - 1)) original[i] = k - 1;
        }
        if (reference || original[i] >= 0) continue;
        before[i + 1] = *at;
        *at = i + 1;
    }
}

/* Keep the samples of a socket that are all equal: the stream was dead, which is refused later. */
static void keep_dead(unsigned char *keep, const mukca_dataset *d, int *count)
{
    int *kept = count + d->n_sockets;
    for (int s = 0; s < 2 * d->n_sockets; s++) count[s] = 0;
    for (int i = 0; i < d->n_rows; i++)
        if (d->socket[i] >= 0) count[d->socket[i]]++, kept[d->socket[i]] += keep[i];
    for (int i = 0; i < d->n_rows; i++) {
        const int s = d->socket[i];
        keep[i] |= s >= 0 && count[s] > 1 && kept[s] == 1;
    }
}

/* Number the items with nonzero map[n] again, -1: the others; returns how many remain. */
static int renumber(int *map, int n)
{
    int kept = 0;
    for (int i = 0; i < n; i++) map[i] = map[i] ? kept++ : -1;
    return kept;
}

/* Remove sockets and placements without samples; scratch map[max(sockets, placements)], zeroed. */
static void prune(mukca_dataset *d, int *map)
{
    const int sockets = d->n_sockets, placements = d->n_placements, distances = d->n_distances;
    for (int i = 0; i < d->n_rows; i++)
        if (d->socket[i] >= 0) map[d->socket[i]] = 1;
    d->n_sockets = renumber(map, sockets);
    for (int s = 0; s < sockets; s++)
        if (map[s] >= 0) d->sockets[map[s]] = d->sockets[s];
    for (int i = 0; i < d->n_rows; i++)
        if (d->socket[i] >= 0) d->socket[i] = map[d->socket[i]];
    d->n_distances = 0;
    for (int k = 0; k < distances; k++) {
        mukca_distance known = d->distances[k];
        known.a = map[known.a], known.b = map[known.b];
        if (known.a >= 0 && known.b >= 0) d->distances[d->n_distances++] = known;
    }
    memset(map, 0, (size_t)placements * sizeof *map);
    for (int s = 0; s < d->n_sockets; s++) map[d->sockets[s].placement] = 1;
    d->n_placements = renumber(map, placements);
    for (int p = 0; p < placements; p++)
        if (map[p] >= 0) d->placements[map[p]] = d->placements[p];
    for (int s = 0; s < d->n_sockets; s++) d->sockets[s].placement = map[d->sockets[s].placement];
}

mukca_status mukca_dataset_keep(mukca_dataset *data, const unsigned char *keep, mukca_error *error)
{
    const int most = data->n_sockets > data->n_placements ? data->n_sockets : data->n_placements;
    int *map = calloc((size_t)most + 1, sizeof *map);
    if (!map) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    const mukca_status status = mukca_dataset_reduce(data, keep, error);
    if (status == MUKCA_OK) prune(data, map);
    free(map);
    return status;
}

static void report(const mukca_dataset *data, int file, const mukca_dataset *reference,
                   const int *original, mukca_notes notes)
{
    const mukca_dataset *source = reference ? reference : data;
    int rows = 0, copies = 0, from = -1;
    for (int i = 0; i < data->n_rows; i++) {
        if (data->file[i] != file) continue;
        rows++;
        if (original[i] < 0) continue;
        copies++;
        if (from < 0) from = source->file[original[i]];
    }
    if (!copies) return;
    const bool within = !reference && from == file;
    const char *name = within ? "others of it" : mukca_file_shown(source->files[from]);
    mukca_note_format(notes, "%s: %d of %d rows repeat %s%s to the last digit; %s",
                      mukca_file_shown(data->files[file]), copies, rows, within ? "" : "rows of ",
                      name, reference ? "not used for testing" : "each is used once");
}

mukca_status mukca_dataset_drop_copies(mukca_dataset *data, const mukca_dataset *reference,
                                       mukca_notes notes, mukca_error *error)
{
    const int n = data->n_rows;
    mukca_pool pool = {0};
    int *original = MUKCA_TAKE(&pool, int, n + 1), copies = 0;
    int *count = MUKCA_TAKE(&pool, int, 2 * data->n_sockets + 1);
    unsigned char *keep = MUKCA_TAKE(&pool, unsigned char, n + 1);
    mukca_status status = MUKCA_OK;
    if (!pool.failed) find(original, &pool, data, reference);
    if (pool.failed) {
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", n);
        goto out;
    }
    for (int i = 0; i < n; i++) keep[i] = original[i] < 0;
    if (!reference) keep_dead(keep, data, count);
    for (int i = 0; i < n; i++) {
        if (keep[i]) original[i] = -1;
        copies += !keep[i];
    }
    for (int f = 0; f < data->n_files && copies; f++) report(data, f, reference, original, notes);
    if (copies) status = mukca_dataset_keep(data, keep, error);
out:
    mukca_pool_free(&pool);
    return status;
}
