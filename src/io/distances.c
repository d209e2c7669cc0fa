/* Known distances between the sockets of a placement. */
#include "io/dataset_build.h"

#include <string.h>

#include "base/file.h"
#include "base/note.h"

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
                mukca_status status = mukca_build_distance(b, r, s, distance);
                if (status != MUKCA_OK) return status;
            }
        }
        if (sockets > 4)
            return mukca_fail(b->error, MUKCA_INPUT,
                              "placement '%s': %d sockets cannot all be the same distance apart; "
                              "give --distances FILE",
                              d->placements[p].name, sockets);
        if (sockets > 2)
            mukca_note_format(b->note, b->context,
                              "placement '%s': %g m assumed between any two of its %d sockets; "
                              "if not, give --distances FILE",
                              d->placements[p].name, distance, sockets);
    }
    return MUKCA_OK;
}

static int find_label(const mukca_dataset *d, int placement, const char *label)
{
    for (int s = 0; s < d->n_sockets; s++)
        if (d->sockets[s].placement == placement && strcmp(d->sockets[s].label, label) == 0)
            return s;
    return -1;
}

/* Apply one row of --distances to all placements with both sockets. */
static void set_distance(void *context, mukca_table *t, const int *column)
{
    mukca_dataset_builder *b = context;
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
        int a = find_label(d, p, label[0]), c = find_label(d, p, label[1]);
        if (a < 0 || c < 0) continue;
        const int low = a < c ? a : c, high = a < c ? c : a;
        for (int k = 0; k < d->n_distances; k++)
            if (d->distances[k].a == low && d->distances[k].b == high)
                mukca_table_fail(t, -1, "this pair of sockets has a distance already");
        mukca_table_stop(t, mukca_build_distance(b, low, high, distance));
        used = true;
    }
    if (!used && t->status == MUKCA_OK)
        mukca_note_format(b->note, b->context,
                          "%s:%d: no placement has sockets '%.40s' and '%.40s'",
                          mukca_file_shown(t->path), t->line, label[0], label[1]);
}

mukca_status mukca_distances_read(mukca_dataset_builder *b, const char *path)
{
    static const char *const names[3] = {"socket_a", "socket_b", "distance_m"};
    mukca_status status = mukca_table_read(path, names, 3, set_distance, b, b->error);
    const mukca_dataset *d = b->data;
    for (int p = 0; p < d->n_placements && status == MUKCA_OK; p++) {
        int known = 0;
        for (int k = 0; k < d->n_distances; k++)
            known += d->sockets[d->distances[k].a].placement == p;
        if (!known)
            status = mukca_fail(b->error, MUKCA_INPUT,
                                "%s: no pair of sockets of placement '%s'; add one",
                                mukca_file_shown(path), d->placements[p].name);
    }
    return status;
}
