/* Datasets from files: detection of the kind of each path, reading, final checks. */
#include "io/dataset.h"

#include <dirent.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/list.h"
#include "base/pool.h"
#include "base/text.h"

/* Bounds: published folders have two holes; a mean needs two samples, a distance two sockets; the
 * upper limits detect tables of another kind. */
enum {
    MOST_HOLES = 100,
    LEAST_ROWS = 2,
    LEAST_SOCKETS = 2,
    MOST_SOCKETS = 1000,
    LACK = 320,
    HOLE_PATH = 1100
};

/* Copy the last `parts` components of a path, without trailing slashes, to `name`; at most the last
 * 63 bytes. */
static void last_parts(char name[MUKCA_NAME_SIZE], const char *path, int parts)
{
    size_t end = strlen(path);
    while (end > 1 && path[end - 1] == '/') end--;
    size_t start = end;
    for (; start > 0; start--)
        if (path[start - 1] == '/' && --parts == 0) break;
    if (end - start >= MUKCA_NAME_SIZE) start = end - MUKCA_NAME_SIZE + 1;
    while (start < end && (path[start] & 0xC0) == 0x80) start++; /* a truncated letter */
    snprintf(name, MUKCA_NAME_SIZE, "%.*s", (int)(end - start), path + start);
    mukca_utf8_mend(name);
}

static mukca_status open_rows(mukca_rows *rows, mukca_dataset_builder *b, const char *path,
                              mukca_table_kind kind)
{
    const mukca_rows_options options = {.kind = kind,
                                        .format = b->options->format,
                                        .notes = b->options->notes,
                                        .warned = b->warned};
    return mukca_rows_open(rows, path, b->chain, &options, b->error);
}

/* Read a table without header whose rows are all of one socket. */
static mukca_status read_hole(mukca_dataset_builder *b, const char *path, int socket)
{
    mukca_rows rows;
    mukca_row row;
    MUKCA_TRY(open_rows(&rows, b, path, MUKCA_NO_HEADER));
    mukca_table_stop(&rows.table, mukca_build_file(b, path));
    while (mukca_rows_next(&rows, &row))
        mukca_table_stop(&rows.table, mukca_build_row(b, &row, socket, rows.table.row));
    return mukca_rows_close(&rows);
}

/* Path of the file of a hole; false: there is none. */
static bool find_hole(char path[HOLE_PATH], const char *folder, int hole, const char *kind)
{
    snprintf(path, HOLE_PATH, "%.1060s/hole_%d%s.csv", folder, hole, kind);
    return access(path, F_OK) == 0;
}

/* Count the sockets of a folder: files hole_0.csv, hole_1.csv and so on without gaps. */
static mukca_status count_holes(int *n, const mukca_dataset_builder *b, const char *folder,
                                int least)
{
    char path[HOLE_PATH];
    int missing = -1;
    *n = 0;
    for (int hole = 0; hole < MOST_HOLES; hole++)
        if (find_hole(path, folder, hole, ""))
            *n = hole + 1;
        else if (missing < 0)
            missing = hole;
    if (*n >= least && (missing < 0 || missing >= *n)) return MUKCA_OK;
    return mukca_fail(b->error, MUKCA_INPUT,
                      "%s: no hole_%d.csv; a placement is a folder with hole_0.csv, hole_1.csv "
                      "and so on",
                      mukca_file_shown(folder), missing);
}

/* Read a folder of one placement with at least `least` sockets; a single one is dropped later. */
static mukca_status read_placement(mukca_dataset_builder *b, const char *folder, int least)
{
    char name[MUKCA_NAME_SIZE], qualified[MUKCA_NAME_SIZE], path[HOLE_PATH], label[16];
    int holes;
    char *whole = realpath(folder, NULL); /* resolves the name of `.` */
    last_parts(name, whole ? whole : folder, 1);
    last_parts(qualified, whole ? whole : folder, 2);
    free(whole);
    MUKCA_TRY(count_holes(&holes, b, folder, least));
    MUKCA_TRY(mukca_build_placement(b, name, qualified));
    for (int hole = 0; hole < holes; hole++) {
        const mukca_dataset *d = b->data;
        const int first = d->n_rows;
        snprintf(label, sizeof label, "%d", hole);
        MUKCA_TRY(mukca_build_socket(b, d->n_placements - 1, label));
        (void)find_hole(path, folder, hole, "");
        MUKCA_TRY(read_hole(b, path, d->n_sockets - 1));
        if (!find_hole(path, folder, hole, "_pose")) continue;
        MUKCA_TRY(mukca_pose_file_read(b, path, first, d->n_rows - first));
    }
    return MUKCA_OK;
}

/* Read one placement, or a folder of placements in alphabetical order. */
static mukca_status read_folder(mukca_dataset_builder *b, const char *folder)
{
    struct dirent **entries;
    char path[HOLE_PATH], inner[HOLE_PATH];
    int found = 0;
    mukca_status status = MUKCA_OK;
    const int n = find_hole(path, folder, 0, "") ? 0 : scandir(folder, &entries, NULL, alphasort);
    if (n < 0) return mukca_file_fail(b->error, folder);
    for (int i = 0; i < n; i++) {
        snprintf(inner, sizeof inner, "%.800s/%.256s", folder, entries[i]->d_name);
        if (status == MUKCA_OK && entries[i]->d_name[0] != '.' && find_hole(path, inner, 0, "")) {
            status = read_placement(b, inner, 1);
            found++;
        }
        free(entries[i]);
    }
    if (n > 0) free(entries);
    return found ? status : read_placement(b, folder, LEAST_SOCKETS);
}

/* State of reading a session file: its placements and sockets so far. */
typedef struct {
    mukca_rows rows;
    char stem[MUKCA_NAME_SIZE]; /* file name without folder and ending */
    int first_placement, first_socket;
    char (*written)[MUKCA_NAME_SIZE]; /* names as written in the file, from first_placement */
} session;

/* Check that a name in a cell has 1 to 63 bytes. */
static void check_name(session *s, const char *name, int column)
{
    mukca_table *t = &s->rows.table;
    if (!*name) mukca_table_fail(t, column, "is empty");
    if (!mukca_utf8_valid(name))
        mukca_table_fail(t, column,
                         "is not UTF-8, or has control characters; save the file as UTF-8");
    if (strlen(name) >= MUKCA_NAME_SIZE)
        mukca_table_fail(t, column, "'%.20s...' is longer than 63 characters", name);
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
    int listed = n;
    char *written = mukca_list_append(&s->written, &listed, sizeof *s->written);
    if (!written) return mukca_fail(b->error, MUKCA_MEMORY, "out of memory");
    snprintf(written, sizeof *s->written, "%s", name);
    snprintf(qualified, sizeof qualified, "%s:%s", s->stem, name);
    qualified[mukca_utf8_fit(qualified, MUKCA_NAME_SIZE - 1)] = '\0';
    *placement = b->data->n_placements;
    return mukca_build_placement(b, name, qualified);
}

/* Index of the row's socket among those of this file, which may be new. */
static int find_socket(mukca_dataset_builder *b, session *s, const mukca_row *row)
{
    const mukca_dataset *d = b->data;
    mukca_table *t = &s->rows.table;
    const char *name = row->placement ? row->placement : s->stem;
    int placement = 0;
    check_name(s, name, s->rows.column.placement);
    check_name(s, row->socket, s->rows.column.socket);
    if (t->status == MUKCA_OK) mukca_table_stop(t, find_placement(&placement, b, s, name));
    if (t->status != MUKCA_OK) return -1;
    for (int k = s->first_socket; k < d->n_sockets; k++)
        if (d->sockets[k].placement == placement && strcmp(d->sockets[k].label, row->socket) == 0)
            return k;
    if (d->n_sockets == MOST_SOCKETS)
        mukca_table_fail(t, s->rows.column.socket, "there are more than %d sockets",
                         (int)MOST_SOCKETS);
    else
        mukca_table_stop(t, mukca_build_socket(b, placement, row->socket));
    return d->n_sockets - 1;
}

static void check_columns(mukca_rows *rows)
{
    const mukca_row_columns *c = &rows->column;
    if (c->socket >= 0 && c->placement < 0)
        mukca_note_format(rows->options.notes,
                          "%s: no column 'placement'; all samples count as one placement",
                          mukca_file_shown(rows->table.path));
    if (c->socket >= 0 || (c->n_measured > 0 && c->placement < 0)) return;
    if (c->placement >= 0)
        mukca_table_fail(&rows->table, -1,
                         "no column 'socket'; add the label of each row's socket");
    const mukca_table *t = &rows->table;
    mukca_table_fail(&rows->table, -1, "%s",
                     mukca_table_find(t, "x") < 0 && mukca_table_find(t, "X") < 0
                         ? "neither a session nor a pose log; the header needs columns socket, or "
                           "x_m, y_m, z_m"
                         : "columns x, y, z without a unit; give --units, as in rad,m or deg,mm, "
                           "or call them x_m, y_m, z_m");
}

/* Limit the number of targets to that of the diagnosis. */
static void check_targets(const mukca_dataset *d, session *s, const char *name)
{
    int t = 0;
    check_name(s, name, s->rows.column.target);
    while (t < d->n_targets && strcmp(d->targets[t], name) != 0) t++;
    if (t >= MUKCA_ROWS_TARGETS)
        mukca_table_fail(&s->rows.table, s->rows.column.target, "more than %d targets",
                         (int)MUKCA_ROWS_TARGETS);
}

static void read_rows(mukca_dataset_builder *b, session *s)
{
    mukca_row row;
    int measured = 0, unmeasured = 0; /* one per row and target */
    mukca_table *t = &s->rows.table;
    while (mukca_rows_next(&s->rows, &row)) {
        if (!row.socket && isnan(row.position[0])) { /* the tracker lost the target */
            unmeasured++;
            continue;
        }
        if (row.socket) row.target = NULL; /* the target is the ball */
        if (row.target) check_targets(b->data, s, row.target);
        const int socket = row.socket ? find_socket(b, s, &row) : -1;
        if (t->status == MUKCA_OK) mukca_table_stop(t, mukca_build_row(b, &row, socket, t->row));
        measured++;
    }
    if (t->status != MUKCA_OK) return;
    if (measured == 0)
        mukca_table_fail(
            t, MUKCA_WHOLE_TABLE,
            t->row == 0 ? "has a header but no rows" : "no row has a measured position");
    else if (unmeasured)
        mukca_note_format(b->options->notes, "%s: %d of %d %s ignored: no measured position",
                          mukca_file_shown(t->path), unmeasured, measured + unmeasured,
                          s->rows.column.n_measured > 1 ? "measurements" : "rows");
}

static mukca_status read_table(mukca_dataset_builder *b, const char *path)
{
    session s = {.first_placement = b->data->n_placements, .first_socket = b->data->n_sockets};
    MUKCA_TRY(open_rows(&s.rows, b, path, MUKCA_HEADER));
    last_parts(s.stem, path, 1);
    char *dot = strrchr(s.stem, '.');
    if (dot && dot != s.stem) *dot = '\0';
    b->data->by_command |= s.rows.by_command;
    check_columns(&s.rows);
    if (b->options->threads > 1) mukca_table_read_ahead(&s.rows.table);
    mukca_table_stop(&s.rows.table, mukca_build_file(b, path));
    read_rows(b, &s);
    free(s.written);
    return mukca_rows_close(&s.rows);
}

static const char *file_of(const mukca_dataset *d, int socket)
{
    for (int i = 0; i < d->n_rows; i++)
        if (d->socket[i] == socket) return mukca_file_shown(d->files[d->file[i]]);
    return "";
}

/* Describe what a placement with so many `good` sockets lacks; "": nothing. */
static void find_lack(char text[LACK], const mukca_dataset *d, int placement, const int *rows,
                      int good)
{
    const char *name = d->placements[placement].name;
    int last = 0, poor = -1;
    text[0] = '\0';
    for (int s = 0; s < d->n_sockets; s++) {
        if (d->sockets[s].placement != placement) continue;
        last = s;
        if (poor < 0 && rows[s] < LEAST_ROWS) poor = s;
    }
    if (poor >= 0)
        snprintf(text, LACK,
                 "%s%splacement '%s', socket '%s': %d row%s; at least %d are needed, 20 or more "
                 "recommended",
                 file_of(d, poor), rows[poor] ? ": " : "", name, d->sockets[poor].label, rows[poor],
                 rows[poor] == 1 ? "" : "s", LEAST_ROWS);
    else if (good < LEAST_SOCKETS)
        snprintf(text, LACK,
                 "%s: placement '%s': only one socket; at least two, a known distance apart, are "
                 "needed",
                 file_of(d, last), name);
}

/* Drop incomplete placements and sockets, with a note for each; an error if nothing remains. */
static mukca_status drop_unfinished(const mukca_dataset_builder *b)
{
    mukca_dataset *d = b->data;
    mukca_pool pool = {0};
    char text[LACK];
    int *rows = MUKCA_TAKE(&pool, int, d->n_sockets + 1), left = 0; /* of each socket */
    int *good = MUKCA_TAKE(&pool, int, d->n_placements + 1); /* sockets with enough of them */
    unsigned char *keep = MUKCA_TAKE(&pool, unsigned char, d->n_rows + 1);
    mukca_status status = MUKCA_OK;
    if (pool.failed) {
        status = mukca_fail(b->error, MUKCA_MEMORY, "out of memory");
        goto out;
    }
    for (int i = 0; i < d->n_rows; i++)
        if (d->socket[i] >= 0) rows[d->socket[i]]++;
    for (int s = 0; s < d->n_sockets; s++) good[d->sockets[s].placement] += rows[s] >= LEAST_ROWS;
    for (int i = 0; i < d->n_rows; i++) {
        const int s = d->socket[i], p = mukca_dataset_placement(d, i);
        keep[i] = s < 0 || (rows[s] >= LEAST_ROWS && good[p] >= LEAST_SOCKETS);
        left += keep[i];
    }
    for (int p = 0; p < d->n_placements && status == MUKCA_OK; p++) {
        find_lack(text, d, p, rows, good[p]);
        if (*text && left == 0)
            status = mukca_fail(b->error, MUKCA_INPUT, "%s", text);
        else if (*text)
            mukca_note_format(b->options->notes, "%s; %s not used", text,
                              good[p] < LEAST_SOCKETS ? "the placement is" : "the socket is");
    }
    if (status == MUKCA_OK && left < d->n_rows) status = mukca_dataset_keep(d, keep, b->error);
out:
    mukca_pool_free(&pool);
    return status;
}

static mukca_status read_path(mukca_dataset_builder *b, const char *path)
{
    struct stat info;
    if (strcmp(path, "-") == 0) return read_table(b, path);
    if (stat(path, &info) != 0) return mukca_file_fail(b->error, path);
    return S_ISDIR(info.st_mode) ? read_folder(b, path) : read_table(b, path);
}

mukca_status mukca_dataset_load(mukca_dataset *data, const mukca_chain *chain,
                                const char *const *paths, int n_paths,
                                const mukca_dataset_options *options, mukca_error *error)
{
    const mukca_dataset_options defaults = {0};
    if (!options) options = &defaults;
    mukca_dataset_builder b = {
        .data = data, .chain = chain, .options = options, .error = error, .payload = NAN};
    memset(data, 0, sizeof *data);
    data->n_joints = chain->n_joints;
    mukca_status status = MUKCA_OK;
    for (int i = 0; i < n_paths && status == MUKCA_OK; i++) {
        b.payload = options->payload ? options->payload[i] : (double)NAN;
        status = read_path(&b, paths[i]);
    }
    if (status == MUKCA_OK && !options->partial)
        status = mukca_dataset_drop_copies(data, NULL, options->notes, error);
    if (status == MUKCA_OK && !options->partial) status = drop_unfinished(&b);
    if (status == MUKCA_OK)
        status = options->distances
                     ? mukca_distances_read(&b, options->distances)
                     : mukca_distances_set(
                           &b, options->distance > 0 ? options->distance : MUKCA_DISTANCE);
    if (status != MUKCA_OK) mukca_dataset_free(data);
    return status;
}
