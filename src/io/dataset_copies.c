/* Detection and removal of duplicate samples. */
#include "io/dataset.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
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

static bool repeats(const mukca_dataset *a, int i, const mukca_dataset *b, int k)
{
    const int n = a->n_joints;
    bool same = memcmp(a->q + (size_t)i * (size_t)n, b->q + (size_t)k * (size_t)n,
                       (size_t)n * sizeof *a->q) == 0 &&
                strcmp(label(a, i), label(b, k)) == 0;
    for (int c = 0; c < MUKCA_COLUMNS && same; c++)
        same = agree(a->column[c], i, b->column[c], k, mukca_column_width(c, n));
    return same;
}

/* A sample in a list sorted by joint angles; `source`: of the other dataset. */
typedef struct {
    const double *q;
    size_t bytes;
    int row;
    bool source;
} sample;

static int compare(const void *a, const void *b)
{
    const sample *x = a, *y = b;
    const int order = memcmp(x->q, y->q, x->bytes);
    return order ? order : x->source != y->source ? y->source - x->source : x->row - y->row;
}

/* original[n_rows]: index of the sample of `of` (NULL: an earlier one of `data`) that each sample
 * repeats, or -1; scratch list[samples of both]. */
static void find(int *original, const mukca_dataset *data, const mukca_dataset *of, sample *list)
{
    const mukca_dataset *sets[2] = {of, data};
    const size_t width = (size_t)data->n_joints, bytes = width * sizeof *data->q;
    int n = 0, first = 0, kept = 0; /* list[first, first + kept): of these angles, to be repeated */
    for (int s = !of; s < 2; s++)
        for (int i = 0; i < sets[s]->n_rows; i++)
            list[n++] = (sample){sets[s]->q + (size_t)i * width, bytes, i, s == 0};
    qsort(list, (size_t)n, sizeof *list, compare);
    for (int k = 0; k < n; k++) {
        const sample now = list[k];
        if (memcmp(list[first].q, now.q, bytes) != 0) first = k, kept = 0;
        if (!now.source) original[now.row] = -1;
        for (int c = kept - 1; c >= 0 && c >= kept - MOST_COMPARED && !now.source; c--)
            if (repeats(data, now.row, of ? of : data, list[first + c].row)) {
                original[now.row] = list[first + c].row;
                break;
            }
        if (now.source || (!of && original[now.row] < 0)) list[first + kept++] = now;
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
    mukca_dataset kept = {0};
    const int most = data->n_sockets > data->n_placements ? data->n_sockets : data->n_placements;
    int *map = calloc((size_t)most + 1, sizeof *map);
    if (!map) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    const mukca_status status = mukca_dataset_subset(&kept, data, keep, error);
    if (status == MUKCA_OK) {
        mukca_dataset_free(data);
        *data = kept;
        prune(data, map);
    }
    free(map);
    return status;
}

/* Note the number of duplicates of one file. */
static void report(const mukca_dataset *data, int file, const mukca_dataset *of,
                   const int *original, mukca_note_fn *note, void *context)
{
    const mukca_dataset *source = of ? of : data;
    int rows = 0, copies = 0, from = -1;
    for (int i = 0; i < data->n_rows; i++) {
        if (data->file[i] != file) continue;
        rows++;
        if (original[i] < 0) continue;
        copies++;
        if (from < 0) from = source->file[original[i]];
    }
    if (!copies) return;
    const bool within = !of && from == file;
    char name[512];
    snprintf(name, sizeof name, "%s",
             within ? "others of it" : mukca_file_shown(source->files[from]));
    mukca_note_format(note, context, "%s: %d of %d rows repeat %s%s to the last digit; %s",
                      mukca_file_shown(data->files[file]), copies, rows, within ? "" : "rows of ",
                      name, of ? "not used for testing" : "each is used once");
}

mukca_status mukca_dataset_drop_copies(mukca_dataset *data, const mukca_dataset *of,
                                       mukca_note_fn *note, void *context, mukca_error *error)
{
    const int n = data->n_rows;
    mukca_pool pool = {0};
    int *original = MUKCA_TAKE(&pool, int, n + 1), copies = 0;
    int *count = MUKCA_TAKE(&pool, int, 2 * data->n_sockets + 1);
    sample *list = MUKCA_TAKE(&pool, sample, (size_t)n + 1 + (of ? (size_t)of->n_rows : 0));
    unsigned char *keep = MUKCA_TAKE(&pool, unsigned char, n + 1);
    mukca_status status = MUKCA_OK;
    if (pool.failed) {
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", n);
        goto out;
    }
    find(original, data, of, list);
    for (int i = 0; i < n; i++) keep[i] = original[i] < 0;
    if (!of) keep_dead(keep, data, count);
    for (int i = 0; i < n; i++) {
        if (keep[i]) original[i] = -1;
        copies += !keep[i];
    }
    for (int f = 0; f < data->n_files && copies; f++) report(data, f, of, original, note, context);
    if (copies) status = mukca_dataset_keep(data, keep, error);
out:
    mukca_pool_free(&pool);
    return status;
}
