/* Recorded rows, one at a time. */
#include "io/rows.h"

#include <math.h>
#include <string.h>

#include "base/file.h"
#include "base/note.h"
#include "base/number.h"
#include "base/suggest.h"

/* Beyond two turns an angle is in degrees (a joint turns at most once or twice; 13 degrees are
 * less, but some row of a recording is beyond). */
static const double most_angle = 4 * 3.14159265358979323846 + 1e-6;
/* Beyond these a length is in millimetres: no arm reaches 50 m, no linear axis is 20 m long. */
static const double most_length = 50, most_prismatic = 20;
/* rad or m: encoders exceed the URDF's limits a little; more is worth a note */
static const double limit_tolerance = 0.05;
/* What a quaternion written with three decimals deviates from length 1 at most. */
static const double length_tolerance = 0.01;

static mukca_status fail_header(const mukca_rows *rows, const char *joint, mukca_error *error)
{
    const mukca_table *t = &rows->table;
    const char *meant = NULL;
    int best = 99;
    for (int c = 0; c < t->n_columns; c++) {
        double value;
        if (mukca_number_parse(&value, t->header[c]))
            return mukca_table_fail(
                error, t, -1, "no column for joint '%s'; the first line must be a header of names",
                joint);
        if (mukca_chain_find_joint(rows->chain, t->header[c]) < 0 &&
            mukca_suggest_better(&best, joint, t->header[c]))
            meant = t->header[c];
    }
    if (meant)
        return mukca_table_fail(error, t, -1,
                                "no column for joint '%s' of the chain; did you mean '%.40s'?",
                                joint, meant);
    return mukca_table_fail(error, t, -1,
                            "no column for joint '%s' of the chain; check --urdf and --tip", joint);
}

/* Columns of the header that are read; the others get a note. */
typedef struct {
    mukca_rows *rows;
    bool known[MUKCA_TABLE_COLUMNS];
} header;

/* Column `prefix``suffix`, -1 where absent. */
static int find(header *h, const char *prefix, const char *suffix)
{
    char name[MUKCA_NAME_SIZE + 16];
    snprintf(name, sizeof name, "%s%s", prefix, suffix);
    const int column = mukca_table_find(&h->rows->table, name);
    if (column >= 0) h->known[column] = true;
    return column;
}

/* All columns of a group or none. */
static mukca_status find_group(int *columns, const char *const *names, int n, header *h,
                               mukca_error *error)
{
    int found = 0;
    const char *absent = NULL;
    for (int i = 0; i < n; i++) {
        columns[i] = find(h, names[i], "");
        found += columns[i] >= 0;
        if (columns[i] < 0) absent = names[i];
    }
    if (found == 0 || found == n) return MUKCA_OK;
    return mukca_table_fail(error, &h->rows->table, -1, "no column '%s'; %s to %s belong together",
                            absent, names[0], names[n - 1]);
}

static void note_unknown_columns(const header *h)
{
    const mukca_table *t = &h->rows->table;
    const mukca_rows_options *o = &h->rows->options;
    char list[120] = "";
    int unknown = 0;
    for (int c = 0; c < t->n_columns; c++) {
        const char *dot = strrchr(t->header[c], '.');
        const size_t used = strlen(list);
        if (h->known[c] || (dot && strcmp(dot, ".spread") == 0)) continue; /* from mukca capture */
        if (used + strlen(t->header[c]) + 8 < sizeof list)
            snprintf(list + used, sizeof list - used, "%s%s", unknown ? ", " : "", t->header[c]);
        else if (used < 3 || strcmp(list + used - 3, "...") != 0)
            snprintf(list + used, sizeof list - used, ", ...");
        unknown++;
    }
    if (unknown)
        mukca_note_format(o->note, o->context, "%s: %d unknown column%s ignored: %s",
                          mukca_file_shown(t->path), unknown, unknown > 1 ? "s" : "", list);
}

static mukca_status map_header(mukca_rows *rows, mukca_error *error)
{
    static const char *const position[] = {"x_m", "y_m", "z_m"};
    static const char *const quaternion[] = {"qw", "qx", "qy", "qz"};
    mukca_columns *c = &rows->column;
    header h = {.rows = rows};
    c->placement = find(&h, "placement", "");
    c->socket = find(&h, "socket", "");
    c->time = find(&h, "time_s", "");
    c->temperature = find(&h, "temperature_c", "");
    c->payload = find(&h, "payload_kg", "");
    for (int j = 0; j < rows->chain->n_joints; j++) {
        const char *name = mukca_chain_joint_name(rows->chain, j);
        c->joint[j] = find(&h, name, "");
        c->effort[j] = find(&h, name, ".effort");
        c->command[j] = find(&h, name, ".command");
        if (j == 0) rows->by_command = c->joint[0] < 0 && c->command[0] >= 0;
        if (rows->by_command) c->joint[j] = c->command[j];
        if (c->joint[j] < 0) return fail_header(rows, name, error);
        c->velocity[j] = find(&h, name, ".velocity");
        rows->has_command |= c->command[j] >= 0;
    }
    mukca_status status = find_group(c->position, position, 3, &h, error);
    if (status != MUKCA_OK) return status;
    status = find_group(c->quaternion, quaternion, 4, &h, error);
    if (status != MUKCA_OK) return status;
    note_unknown_columns(&h);
    /* angles that a driver corrected before it published them (mukca capture --stream corrected) */
    if (strstr(rows->table.comments, "# stream: corrected\n"))
        mukca_note_format(rows->options.note, rows->options.context,
                          "%s: the driver has corrected these angles already; offsets found here "
                          "add to its own",
                          mukca_file_shown(rows->table.path));
    return MUKCA_OK;
}

mukca_status mukca_rows_open(mukca_rows *rows, const char *path, const mukca_chain *chain,
                             const mukca_rows_options *options, mukca_error *error)
{
    *rows = (mukca_rows){.chain = chain, .options = *options};
    mukca_status status = mukca_table_open(&rows->table, path, options->kind, error);
    if (status != MUKCA_OK) return status;
    memset(&rows->column, -1, sizeof rows->column);
    for (int j = 0; j < chain->n_joints; j++) rows->column.joint[j] = j;
    if (rows->table.header) status = map_header(rows, error);
    if (status != MUKCA_OK) mukca_rows_close(rows);
    return status;
}

void mukca_rows_close(mukca_rows *rows)
{
    mukca_table_close(&rows->table);
}

/* An optional number: NaN where there is no column, an empty cell or `nan`. */
static mukca_status read_optional(double *value, const mukca_rows *rows, int column,
                                  mukca_error *error)
{
    *value = (double)NAN;
    if (column < 0) return MUKCA_OK;
    const char *text = rows->table.cell[column];
    if (!*text || strcmp(text, "nan") == 0 || strcmp(text, "NaN") == 0) return MUKCA_OK;
    return mukca_table_number(value, &rows->table, column, error);
}

static mukca_status check_joint(mukca_rows *rows, int j, double q, mukca_error *error)
{
    const mukca_element *e = &rows->chain->element[rows->chain->joint_element[j]];
    const bool linear = e->type == MUKCA_PRISMATIC;
    if (!linear && fabs(q) > most_angle)
        return mukca_table_fail(error, &rows->table, rows->column.joint[j],
                                "joint '%s' is %g, more than two turns; angles are in rad", e->name,
                                q);
    if (linear && fabs(q) > most_prismatic)
        return mukca_table_fail(error, &rows->table, rows->column.joint[j],
                                "joint '%s' is %g; lengths are in m", e->name, q);
    const double beyond = q > e->upper ? q - e->upper : q < e->lower ? e->lower - q : 0;
    if (beyond > limit_tolerance && !rows->warned[j]) {
        mukca_note_format(rows->options.note, rows->options.context,
                          "%s:%d: joint '%s' is %.3g %s beyond its limits",
                          mukca_file_shown(rows->table.path), rows->table.line, e->name, beyond,
                          linear ? "m" : "rad");
        rows->warned[j] = true;
    }
    return MUKCA_OK;
}

mukca_status mukca_rows_check_length(const mukca_table *table, int column, double metres,
                                     mukca_error *error)
{
    if (!(fabs(metres) > most_length)) return MUKCA_OK;
    return mukca_table_fail(error, table, column, "is %g; positions are in m", metres);
}

bool mukca_rows_normalise(double quaternion[4])
{
    double square = 0;
    for (int i = 0; i < 4; i++) square += quaternion[i] * quaternion[i];
    const double length = sqrt(square);
    if (!(fabs(length - 1) <= length_tolerance)) return false;
    for (int i = 0; i < 4; i++) quaternion[i] /= length;
    return true;
}

/* Optional numbers of several columns. */
static mukca_status read_list(double *values, const mukca_rows *rows, const int *columns, int n,
                              mukca_error *error)
{
    for (int i = 0; i < n; i++) {
        const mukca_status status = read_optional(&values[i], rows, columns[i], error);
        if (status != MUKCA_OK) return status;
    }
    return MUKCA_OK;
}

static int count_missing(const double *values, int n)
{
    int missing = 0;
    for (int i = 0; i < n; i++) missing += isnan(values[i]) != 0;
    return missing;
}

static mukca_status check_pose(mukca_row *row, const mukca_rows *rows, mukca_error *error)
{
    const mukca_columns *c = &rows->column;
    for (int i = 0; i < 3; i++) {
        const mukca_status status =
            mukca_rows_check_length(&rows->table, c->position[i], row->position[i], error);
        if (status != MUKCA_OK) return status;
    }
    if (count_missing(row->position, 3) % 3 != 0)
        return mukca_table_fail(error, &rows->table, -1, "a position needs x_m, y_m and z_m");
    if (count_missing(row->quaternion, 4) == 4 || mukca_rows_normalise(row->quaternion))
        return MUKCA_OK;
    return mukca_table_fail(error, &rows->table, c->quaternion[0],
                            "the quaternion's length is not 1 (order: qw qx qy qz)");
}

mukca_status mukca_rows_next(mukca_rows *rows, mukca_row *row, bool *more, mukca_error *error)
{
    const mukca_table *t = &rows->table;
    const mukca_columns *c = &rows->column;
    const int n = rows->chain->n_joints;
    mukca_status status = mukca_table_next(&rows->table, more, error);
    if (status != MUKCA_OK || !*more) return status;
    if (!t->header && t->n_columns != n)
        return mukca_table_fail(error, t, -1,
                                "%d columns, but the chain has %d joints; check --urdf and --tip",
                                t->n_columns, n);
    row->placement = c->placement < 0 ? NULL : t->cell[c->placement];
    row->socket = c->socket < 0 ? NULL : t->cell[c->socket];
    for (int j = 0; j < n; j++) {
        status = mukca_table_number(&row->q[j], t, c->joint[j], error);
        if (status == MUKCA_OK) status = check_joint(rows, j, row->q[j], error);
        if (status != MUKCA_OK) return status;
    }
    const struct {
        double *values;
        const int *columns;
        int n;
    } optional[] = {{row->effort, c->effort, n},
                    {row->command, c->command, n},
                    {row->velocity, c->velocity, n},
                    {&row->time, &c->time, 1},
                    {&row->temperature, &c->temperature, 1},
                    {&row->payload, &c->payload, 1},
                    {row->position, c->position, 3},
                    {row->quaternion, c->quaternion, 4}};
    for (size_t i = 0; i < sizeof optional / sizeof *optional; i++) {
        status = read_list(optional[i].values, rows, optional[i].columns, optional[i].n, error);
        if (status != MUKCA_OK) return status;
    }
    return check_pose(row, rows, error);
}

mukca_row_reading mukca_row_read(const mukca_row *row, const mukca_rows *rows)
{
    return (mukca_row_reading){.q = row->q,
                               .command = rows->has_command ? row->command : NULL,
                               .time = row->time,
                               .payload_kg = row->payload,
                               .placement = -1,
                               .number = rows->table.row};
}
