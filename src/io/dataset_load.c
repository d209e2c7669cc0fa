/* Datasets from files: finds out what each path is, reads it, and checks the whole. */
#include "io/dataset_load.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/utf8.h"
#include "io/dataset_build.h"
#include "io/pose_files.h"

enum { MOST_HOLES = 100, LEAST_ROWS = 2, LEAST_SOCKETS = 2, MOST_SOCKETS = 1000 };
static const double usual_distance = 0.05, most_distance = 10;

/* The last part of a path without slashes at its end and, where asked, without its ending; `up`
 * parts above it included. */
static void base_name(char name[MUKCA_NAME_SIZE], const char *path, int up, bool drop_ending)
{
    char whole[1024];
    size_t end = strlen(path);
    while (end > 1 && path[end - 1] == '/') end--;
    size_t start = end;
    for (int parts = 0; start > 0; start--)
        if (path[start - 1] == '/' && parts++ == up) break;
    if (end - start >= sizeof whole) start = end - sizeof whole + 1;
    memcpy(whole, path + start, end - start);
    whole[end - start] = '\0';
    char *dot = drop_ending ? strrchr(whole, '.') : NULL;
    if (dot && dot != whole) *dot = '\0';
    size_t length = strlen(whole);
    char *tail = whole + (length < MUKCA_NAME_SIZE ? 0 : length - MUKCA_NAME_SIZE + 1);
    while (tail > whole && (*tail & 0xC0) == 0x80) tail++; /* the rest of a letter that was cut */
    mukca_utf8_mend(tail);
    snprintf(name, MUKCA_NAME_SIZE, "%s", tail);
}

static bool name_taken(const mukca_dataset *d, const char *name)
{
    for (int p = 0; p < d->n_placements; p++)
        if (strcmp(d->placements[p].name, name) == 0) return true;
    return false;
}

/* Add a placement under a name that no other has: with the folder above, or a number behind. */
static mukca_status add_placement(int *index, mukca_dataset_builder *b, const char *wanted,
                                  const char *qualified)
{
    char name[MUKCA_NAME_SIZE];
    snprintf(name, sizeof name, "%s", wanted);
    if (name_taken(b->data, name)) snprintf(name, sizeof name, "%s", qualified);
    for (int k = 2; name_taken(b->data, name); k++)
        snprintf(name, sizeof name, "%.*s#%d", (int)mukca_utf8_fit(wanted, 50), wanted, k);
    if (strcmp(name, wanted) != 0)
        mukca_build_note(b, "there is a placement '%s' already; this one is called '%s'", wanted,
                         name);
    return mukca_build_placement(index, b, name);
}

static mukca_status read_hole(mukca_dataset_builder *b, const char *path, int socket)
{
    mukca_rows rows;
    mukca_row row;
    int file = 0;
    mukca_status status =
        mukca_rows_open(&rows, path, MUKCA_NO_HEADER, b->chain, b->note, b->context, b->error);
    if (status) return status;
    status = mukca_build_file(&file, b, path);
    for (bool more = true; status == MUKCA_OK;) {
        status = mukca_rows_next(&rows, &row, &more, b->error);
        if (status || !more) break;
        status = mukca_build_row(b, &row, socket, file, rows.table.row);
    }
    mukca_rows_close(&rows);
    return status;
}

/* How many sockets a folder holds: files hole_0.csv, hole_1.csv and so on, without a gap. */
static mukca_status count_holes(int *n, const mukca_dataset_builder *b, const char *folder)
{
    char path[1100];
    int missing = -1;
    *n = 0;
    for (int hole = 0; hole < MOST_HOLES; hole++) {
        snprintf(path, sizeof path, "%.1000s/hole_%d.csv", folder, hole);
        if (access(path, F_OK) == 0)
            *n = hole + 1;
        else if (missing < 0)
            missing = hole;
    }
    if (*n >= LEAST_SOCKETS && (missing < 0 || missing >= *n)) return MUKCA_OK;
    return mukca_fail(
        b->error, MUKCA_INPUT,
        "%s: no hole_%d.csv; a placement is a folder with hole_0.csv and hole_1.csv%s",
        mukca_table_short_path(folder), missing,
        *n > LEAST_SOCKETS ? ", and others without a gap" : "");
}

static mukca_status read_folder(mukca_dataset_builder *b, const char *folder)
{
    char name[MUKCA_NAME_SIZE], qualified[MUKCA_NAME_SIZE], path[1100];
    int placement, holes;
    char whole[PATH_MAX];
    const char *named = realpath(folder, whole) ? whole : folder; /* `.` has a name, too */
    base_name(name, named, 0, false);
    base_name(qualified, named, 1, false);
    mukca_status status = count_holes(&holes, b, folder);
    if (status == MUKCA_OK) status = add_placement(&placement, b, name, qualified);
    for (int hole = 0; hole < holes && status == MUKCA_OK; hole++) {
        char label[16];
        int socket, first = b->data->n_rows;
        snprintf(path, sizeof path, "%.1000s/hole_%d.csv", folder, hole);
        snprintf(label, sizeof label, "%d", hole);
        status = mukca_build_socket(&socket, b, placement, label);
        if (status == MUKCA_OK) status = read_hole(b, path, socket);
        snprintf(path, sizeof path, "%.1000s/hole_%d_pose.csv", folder, hole);
        if (status == MUKCA_OK && access(path, F_OK) == 0)
            status = mukca_pose_file_read(b, path, first, b->data->n_rows - first);
    }
    return status;
}

/* A session file in reading: the placements and sockets that it has brought so far. */
typedef struct {
    mukca_rows rows;
    char stem[MUKCA_NAME_SIZE]; /* of the file's name */
    int first_placement, first_socket;
    char (*written)[MUKCA_NAME_SIZE]; /* names as they stand in the file, from first_placement */
} session;

/* A name of 1 to 63 letters in a cell. */
static mukca_status check_name(const mukca_dataset_builder *b, const session *s, const char *name,
                               int column)
{
    if (!*name) return mukca_table_fail(b->error, &s->rows.table, column, "is empty");
    if (!mukca_utf8_valid(name))
        return mukca_table_fail(b->error, &s->rows.table, column,
                                "is not UTF-8, nor is the file; save it as such");
    if (strlen(name) < MUKCA_NAME_SIZE) return MUKCA_OK;
    return mukca_table_fail(b->error, &s->rows.table, column,
                            "'%.20s...' is longer than 63 letters", name);
}

static mukca_status find_placement(int *placement, mukca_dataset_builder *b, session *s,
                                   const char *name)
{
    const int n = b->data->n_placements - s->first_placement;
    for (int p = 0; p < n; p++)
        if (strcmp(s->written[p], name) == 0) {
            *placement = s->first_placement + p;
            return MUKCA_OK;
        }
    char qualified[2 * MUKCA_NAME_SIZE + 2];
    void *grown = realloc(s->written, ((size_t)n + 1) * sizeof *s->written);
    if (!grown) return mukca_fail(b->error, MUKCA_MEMORY, "out of memory");
    s->written = grown;
    snprintf(s->written[n], sizeof s->written[n], "%s", name);
    snprintf(qualified, sizeof qualified, "%s:%s", s->stem, name);
    qualified[mukca_utf8_fit(qualified, MUKCA_NAME_SIZE - 1)] = '\0';
    return add_placement(placement, b, name, qualified);
}

/* Index of the row's socket, new where it is; of this file only. */
static mukca_status find_socket(int *socket, mukca_dataset_builder *b, session *s,
                                const mukca_row *row)
{
    const mukca_dataset *d = b->data;
    const char *name = row->placement ? row->placement : s->stem;
    int placement = 0;
    mukca_status status = check_name(b, s, name, s->rows.placement);
    if (status == MUKCA_OK) status = check_name(b, s, row->socket, s->rows.socket);
    if (status == MUKCA_OK) status = find_placement(&placement, b, s, name);
    if (status) return status;
    for (int k = s->first_socket; k < d->n_sockets; k++)
        if (d->sockets[k].placement == placement && strcmp(d->sockets[k].label, row->socket) == 0) {
            *socket = k;
            return MUKCA_OK;
        }
    if (d->n_sockets == MOST_SOCKETS)
        return mukca_table_fail(b->error, &s->rows.table, s->rows.socket,
                                "there are more than %d sockets", (int)MOST_SOCKETS);
    return mukca_build_socket(socket, b, placement, row->socket);
}

static mukca_status read_table(mukca_dataset_builder *b, const char *path)
{
    session s = {.first_placement = b->data->n_placements, .first_socket = b->data->n_sockets};
    mukca_row row;
    int file = 0, blind = 0;
    mukca_status status =
        mukca_rows_open(&s.rows, path, MUKCA_HEADER, b->chain, b->note, b->context, b->error);
    if (status) return status;
    base_name(s.stem, path, 0, true);
    if (s.rows.socket < 0 && (s.rows.position[0] < 0 || s.rows.placement >= 0))
        status = mukca_table_fail(b->error, &s.rows.table, -1,
                                  s.rows.placement >= 0
                                      ? "no column 'socket': which socket held the ball?"
                                      : "neither a session (placement, socket) nor a pose log "
                                        "(x_m, y_m, z_m): the header lacks such columns");
    if (status == MUKCA_OK) status = mukca_build_file(&file, b, path);
    while (status == MUKCA_OK) {
        bool more;
        int socket = -1;
        status = mukca_rows_next(&s.rows, &row, &more, b->error);
        if (status || !more) break;
        if (!row.socket && isnan(row.position[0])) { /* the tracker lost sight */
            blind++;
            continue;
        }
        if (row.socket) status = find_socket(&socket, b, &s, &row);
        if (status == MUKCA_OK) status = mukca_build_row(b, &row, socket, file, s.rows.table.row);
    }
    if (status == MUKCA_OK && s.rows.table.row == 0)
        status = mukca_fail(b->error, MUKCA_INPUT, "%s: holds a header but no rows",
                            mukca_table_short_path(path));
    if (status == MUKCA_OK && blind == s.rows.table.row)
        status = mukca_fail(b->error, MUKCA_INPUT, "%s: no row has a measured position",
                            mukca_table_short_path(path));
    if (status == MUKCA_OK && blind)
        mukca_build_note(b, "%s: %d of %d rows have no measured position, and are left out",
                         mukca_table_short_path(path), blind, s.rows.table.row);
    mukca_rows_close(&s.rows);
    free(s.written);
    return status;
}

/* The file of the socket's first row, so that --test data are told from the others. */
static const char *file_of(const mukca_dataset *d, int socket)
{
    for (int i = 0; i < d->n_rows; i++)
        if (d->socket[i] == socket) return mukca_table_short_path(d->files[d->file[i]]);
    return "";
}

/* How many sockets has a placement, how many rows a socket. */
static mukca_status check_counts(const mukca_dataset_builder *b)
{
    const mukca_dataset *d = b->data;
    for (int s = 0; s < d->n_sockets; s++) {
        int rows = 0;
        for (int i = 0; i < d->n_rows; i++) rows += d->socket[i] == s;
        if (rows < LEAST_ROWS)
            return mukca_fail(
                b->error, MUKCA_INPUT,
                "%s%splacement '%s', socket '%s': %d row%s; at least %d are needed, 20 or "
                "more are good",
                file_of(d, s), rows ? ": " : "", d->placements[d->sockets[s].placement].name,
                d->sockets[s].label, rows, rows == 1 ? "" : "s", LEAST_ROWS);
    }
    for (int p = 0; p < d->n_placements; p++) {
        int sockets = 0, last = 0;
        for (int s = 0; s < d->n_sockets; s++)
            if (d->sockets[s].placement == p) sockets++, last = s;
        if (sockets < LEAST_SOCKETS)
            return mukca_fail(b->error, MUKCA_INPUT,
                              "%s: placement '%s': only one socket; at least two, a known distance "
                              "apart, are needed",
                              file_of(d, last), d->placements[p].name);
    }
    return MUKCA_OK;
}

/* Every pair of a placement's sockets is the same distance apart. */
static mukca_status set_one_distance(mukca_dataset_builder *b, double distance)
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
                if (status) return status;
            }
        }
        if (sockets > 4)
            return mukca_fail(b->error, MUKCA_INPUT,
                              "placement '%s': %d sockets cannot all be the same distance apart; "
                              "give their distances by --distances",
                              d->placements[p].name, sockets);
        if (sockets > 2)
            mukca_build_note(b,
                             "placement '%s': its %d sockets are taken to be %g m apart each; "
                             "--distances tells otherwise",
                             d->placements[p].name, sockets, distance);
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

/* One row of --distances, for all placements that have both sockets. */
static mukca_status set_distance(mukca_dataset_builder *b, const mukca_table *t,
                                 const int column[3])
{
    const mukca_dataset *d = b->data;
    double distance;
    mukca_status status = mukca_table_number(&distance, t, column[2], b->error);
    if (status) return status;
    if (!(distance > 0))
        return mukca_table_fail(b->error, t, column[2], "%g: a distance must be above 0", distance);
    if (distance > most_distance)
        return mukca_table_fail(b->error, t, column[2], "%g looks like millimetres; give m",
                                distance);
    const char *label[2] = {t->cell[column[0]], t->cell[column[1]]};
    if (strcmp(label[0], label[1]) == 0)
        return mukca_table_fail(b->error, t, column[1], "is the same socket as socket_a");
    bool used = false;
    for (int p = 0; p < d->n_placements; p++) {
        int a = find_label(d, p, label[0]), c = find_label(d, p, label[1]);
        if (a < 0 || c < 0) continue;
        for (int k = 0; k < d->n_distances; k++)
            if ((d->distances[k].a == a && d->distances[k].b == c) ||
                (d->distances[k].a == c && d->distances[k].b == a))
                return mukca_table_fail(b->error, t, -1, "this pair of sockets comes twice");
        status = mukca_build_distance(b, a < c ? a : c, a < c ? c : a, distance);
        if (status) return status;
        used = true;
    }
    if (!used)
        mukca_build_note(b, "%s:%d: no placement has sockets '%.40s' and '%.40s'",
                         mukca_table_short_path(t->path), t->line, label[0], label[1]);
    return MUKCA_OK;
}

static mukca_status read_distances(mukca_dataset_builder *b, const char *path)
{
    static const char *const names[3] = {"socket_a", "socket_b", "distance_m"};
    mukca_table t;
    int column[3];
    mukca_status status = mukca_table_open(&t, path, MUKCA_HEADER, b->error);
    for (int i = 0; i < 3 && status == MUKCA_OK; i++)
        status = mukca_table_require(&column[i], &t, names[i], b->error);
    while (status == MUKCA_OK) {
        bool more;
        status = mukca_table_next(&t, &more, b->error);
        if (status || !more) break;
        status = set_distance(b, &t, column);
    }
    mukca_table_close(&t);
    const mukca_dataset *d = b->data;
    for (int p = 0; p < d->n_placements && status == MUKCA_OK; p++) {
        int known = 0;
        for (int k = 0; k < d->n_distances; k++)
            known += d->sockets[d->distances[k].a].placement == p;
        if (!known)
            status = mukca_fail(b->error, MUKCA_INPUT,
                                "%s: names no pair of the sockets of placement '%s'",
                                mukca_table_short_path(path), d->placements[p].name);
    }
    return status;
}

static mukca_status read_path(mukca_dataset_builder *b, const char *path)
{
    struct stat info;
    if (strcmp(path, "-") == 0) return read_table(b, path);
    if (stat(path, &info) != 0)
        return mukca_fail(b->error, MUKCA_INPUT, "%s: cannot read: %s",
                          mukca_table_short_path(path), strerror(errno));
    return S_ISDIR(info.st_mode) ? read_folder(b, path) : read_table(b, path);
}

mukca_status mukca_dataset_load(mukca_dataset *data, const mukca_chain *chain,
                                const char *const *paths, int n_paths,
                                const mukca_dataset_options *options, mukca_note_fn *note,
                                void *context, mukca_error *error)
{
    const mukca_dataset_options defaults = {0};
    if (!options) options = &defaults;
    mukca_dataset_builder b = {
        .data = data, .chain = chain, .note = note, .context = context, .error = error};
    memset(data, 0, sizeof *data);
    data->n_joints = chain->n_joints;
    mukca_status status = MUKCA_OK;
    for (int i = 0; i < n_paths && status == MUKCA_OK; i++) status = read_path(&b, paths[i]);
    if (status == MUKCA_OK && !options->partial) status = check_counts(&b);
    if (status == MUKCA_OK && options->distances) status = read_distances(&b, options->distances);
    if (status == MUKCA_OK && !options->distances)
        status = set_one_distance(&b, options->distance > 0 ? options->distance : usual_distance);
    if (status) mukca_dataset_free(data);
    return status;
}
