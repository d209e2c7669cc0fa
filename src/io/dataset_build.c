/* Construction of a dataset, sample by sample. */
#include "io/dataset.h"

#include <math.h>
#include <string.h>

#include "base/file.h"
#include "base/list.h"
#include "base/text.h"
#include "model/dataset_subset.h"

/* The memory; NULL, with the error set, if it is exhausted. */
static void *check(void *memory, const mukca_dataset_builder *builder)
{
    if (!memory) mukca_fail(builder->error, MUKCA_MEMORY, "out of memory while reading data");
    return memory;
}

mukca_status mukca_build_file(mukca_dataset_builder *builder, const char *path)
{
    mukca_dataset *d = builder->data;
    char *file = check(mukca_list_append(&d->files, &d->n_files, sizeof *d->files), builder);
    if (!file) return MUKCA_MEMORY;
    snprintf(file, sizeof *d->files, "%s", path);
    mukca_utf8_mend(file);
    return MUKCA_OK;
}

static bool has_placement(const mukca_dataset *d, const char *name)
{
    for (int p = 0; p < d->n_placements; p++)
        if (strcmp(d->placements[p].name, name) == 0) return true;
    return false;
}

mukca_status mukca_build_placement(mukca_dataset_builder *builder, const char *wanted,
                                   const char *qualified)
{
    mukca_dataset *d = builder->data;
    mukca_placement placement = {.name = ""};
    char *name = placement.name;
    snprintf(name, sizeof placement.name, "%s", has_placement(d, wanted) ? qualified : wanted);
    for (int k = 2; has_placement(d, name); k++)
        snprintf(name, sizeof placement.name, "%.*s#%d", (int)mukca_utf8_fit(wanted, 50), wanted,
                 k);
    if (strcmp(name, wanted) != 0)
        mukca_note_format(builder->options->notes,
                          "placement '%s' exists already; this one is called '%s'", wanted, name);
    mukca_placement *added =
        check(mukca_list_append(&d->placements, &d->n_placements, sizeof *added), builder);
    if (!added) return MUKCA_MEMORY;
    *added = placement;
    return MUKCA_OK;
}

mukca_status mukca_build_socket(mukca_dataset_builder *builder, int placement, const char *label)
{
    mukca_dataset *d = builder->data;
    mukca_socket *socket =
        check(mukca_list_append(&d->sockets, &d->n_sockets, sizeof *socket), builder);
    if (!socket) return MUKCA_MEMORY;
    socket->placement = placement;
    snprintf(socket->label, sizeof socket->label, "%s", label);
    return MUKCA_OK;
}

static mukca_status build_distance(mukca_dataset_builder *builder, int a, int b, double metres)
{
    mukca_dataset *d = builder->data;
    mukca_distance *added =
        check(mukca_list_append(&d->distances, &d->n_distances, sizeof *added), builder);
    if (!added) return MUKCA_MEMORY;
    *added = (mukca_distance){
        .a = a, .b = b, .distance = metres, .sigma = builder->options->distance_sigma};
    mukca_dataset_number_distance(d);
    return MUKCA_OK;
}

/* Lengthen the list of a column from `from` samples to all: NaN. */
static mukca_status extend(mukca_dataset_builder *builder, int column, int from)
{
    mukca_dataset *d = builder->data;
    const int width = mukca_column_width(column, d->n_joints);
    while (from < d->n_rows) {
        double *values = check(
            mukca_list_append(&d->column[column], &from, (size_t)width * sizeof *values), builder);
        if (!values) return MUKCA_MEMORY;
        for (int k = 0; k < width; k++) values[k] = (double)NAN;
    }
    return MUKCA_OK;
}

/* Store the sample's values of a column unless all are NaN; the first sample with a value creates
 * the list. */
static mukca_status set_values(mukca_dataset_builder *builder, int row, int column,
                               const double *values)
{
    double **list = &builder->data->column[column];
    const int width = mukca_column_width(column, builder->data->n_joints);
    bool any = false;
    for (int i = 0; i < width; i++) any |= !isnan(values[i]);
    if (!any) return MUKCA_OK;
    MUKCA_TRY(extend(builder, column, *list ? builder->data->n_rows : 0));
    if (*list) /* there is a sample */
        memcpy(*list + (size_t)row * (size_t)width, values, (size_t)width * sizeof *values);
    return MUKCA_OK;
}

/* Append an index to a list of n. */
static mukca_status add_index(mukca_dataset_builder *builder, int **list, int n, int index)
{
    int *added = check(mukca_list_append(list, &n, sizeof *added), builder);
    if (!added) return MUKCA_MEMORY;
    *added = index;
    return MUKCA_OK;
}

/* Append the target of sample i; the first sample with a target creates the list. */
static mukca_status add_target(mukca_dataset_builder *builder, int i, const char *name)
{
    mukca_dataset *d = builder->data;
    const bool first = !d->target;
    int t = 0;
    if (!name && first) return MUKCA_OK;
    for (int k = 0; k < i && first; k++) MUKCA_TRY(add_index(builder, &d->target, k, -1));
    while (name && t < d->n_targets && strcmp(d->targets[t], name) != 0) t++;
    if (name && t == d->n_targets) {
        char *added =
            check(mukca_list_append(&d->targets, &d->n_targets, sizeof *d->targets), builder);
        if (!added) return MUKCA_MEMORY;
        snprintf(added, sizeof *d->targets, "%s", name);
    }
    return add_index(builder, &d->target, i, name ? t : -1);
}

mukca_status mukca_build_row(mukca_dataset_builder *builder, const mukca_row *row, int socket,
                             int row_in_file)
{
    enum { MOST = 1 << 28 }; /* samples; indices are int */
    mukca_dataset *d = builder->data;
    const int i = d->n_rows;
    if (i == MOST) return mukca_fail(builder->error, MUKCA_MEMORY, "too many rows");
    MUKCA_TRY(add_index(builder, &d->socket, i, socket));
    MUKCA_TRY(add_index(builder, &d->file, i, d->n_files - 1));
    MUKCA_TRY(add_index(builder, &d->row, i, row_in_file));
    MUKCA_TRY(add_target(builder, i, row->target));
    d->n_rows++;
    for (int c = 0; c < MUKCA_COLUMNS; c++) {
        const bool unknown = c == MUKCA_COLUMN_PAYLOAD && isnan(row->payload[0]);
        MUKCA_TRY(extend(builder, c, d->column[c] ? i : d->n_rows)); /* if there is a list */
        MUKCA_TRY(set_values(builder, i, c, unknown ? &builder->payload : row->number[c]));
    }
    return MUKCA_OK;
}

mukca_status mukca_build_pose(mukca_dataset_builder *builder, int row, const double pose[7])
{
    MUKCA_TRY(set_values(builder, row, MUKCA_COLUMN_POSITION, pose));
    return set_values(builder, row, MUKCA_COLUMN_QUATERNION, pose + 3);
}

/* ---- known distances between the sockets of a placement ---- */

/* m; longer than any artefact; detects 50 mm given as 50 */
static const double most_distance = 10;

mukca_status mukca_distances_set(mukca_dataset_builder *b, double distance)
{
    const mukca_dataset *d = b->data;
    for (int p = 0; p < d->n_placements; p++) {
        int sockets = 0;
        for (int s = 0; s < d->n_sockets; s++) {
            if (d->sockets[s].placement != p) continue;
            sockets++;
            for (int r = 0; r < s; r++) {
                if (d->sockets[r].placement != p) continue;
                MUKCA_TRY(build_distance(b, r, s, distance));
            }
        }
        if (sockets > 4)
            return mukca_fail(b->error, MUKCA_INPUT,
                              "placement '%s': %d sockets cannot all be the same distance apart; "
                              "give --distances FILE",
                              d->placements[p].name, sockets);
        if (sockets > 2)
            mukca_note_format(b->options->notes,
                              "placement '%s': %g m assumed between any two of its %d sockets; "
                              "if not, give --distances FILE",
                              d->placements[p].name, distance, sockets);
    }
    return MUKCA_OK;
}

/* Apply one row of --distances to all placements with both sockets. */
static void set_distance(mukca_dataset_builder *b, mukca_table *t, const int column[3])
{
    const mukca_dataset *d = b->data;
    const double distance = mukca_table_number(t, column[2]);
    const char *label[2] = {t->cell[column[0]], t->cell[column[1]]};
    if (!(distance > 0)) mukca_table_fail(t, column[2], "%g is not above 0", distance);
    if (distance > most_distance)
        mukca_table_fail(t, column[2], "is %g; distances are in m", distance);
    if (strcmp(label[0], label[1]) == 0)
        mukca_table_fail(t, column[1], "is the same socket as socket_a");
    bool used = false;
    for (int p = 0; p < d->n_placements && t->status == MUKCA_OK; p++) {
        const char *name = d->placements[p].name;
        const int a = mukca_dataset_find_socket(d, name, label[0]),
                  c = mukca_dataset_find_socket(d, name, label[1]);
        if (a < 0 || c < 0) continue;
        const int low = a < c ? a : c, high = a < c ? c : a;
        for (int k = 0; k < d->n_distances; k++)
            if (d->distances[k].a == low && d->distances[k].b == high)
                mukca_table_fail(t, -1, "this pair of sockets has a distance already");
        mukca_table_stop(t, build_distance(b, low, high, distance));
        used = true;
    }
    if (!used && t->status == MUKCA_OK)
        mukca_note_format(b->options->notes, "%s:%d: no placement has sockets '%.40s' and '%.40s'",
                          mukca_file_shown(t->path), t->line, label[0], label[1]);
}

mukca_status mukca_distances_read(mukca_dataset_builder *b, const char *path)
{
    static const char *const names[3] = {"socket_a", "socket_b", "distance_m"};
    mukca_table table;
    int column[3];
    mukca_table_open(&table, path, MUKCA_HEADER, b->error);
    for (int i = 0; i < 3; i++) column[i] = mukca_table_require(&table, names[i]);
    while (mukca_table_next(&table)) set_distance(b, &table, column);
    MUKCA_TRY(mukca_table_close(&table));
    const mukca_dataset *d = b->data;
    for (int p = 0; p < d->n_placements; p++) {
        int known = 0;
        for (int k = 0; k < d->n_distances; k++)
            known += d->sockets[d->distances[k].a].placement == p;
        if (!known)
            return mukca_fail(b->error, MUKCA_INPUT,
                              "%s: no pair of sockets of placement '%s'; add one",
                              mukca_file_shown(path), d->placements[p].name);
    }
    return MUKCA_OK;
}
