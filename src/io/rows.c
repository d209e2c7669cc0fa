/* Recorded rows, one at a time. */
#include "io/rows.h"

#include <math.h>
#include <string.h>

#include "base/number.h"
#include "base/suggest.h"

/* Beyond two turns an angle is in degrees, beyond these lengths (m) one is in millimetres. */
static const double most_angle = 4 * 3.14159265358979323846 + 1e-6;
static const double most_length = 50, most_prismatic = 20;
static const double limit_tolerance = 0.05; /* rad or m */

/* Text of a header cell, "" past its end. */
static const char *name_of(const mukca_rows *rows, int column)
{
    return rows->table.header[column];
}

static mukca_status missing_joint(const mukca_rows *rows, const char *joint, mukca_error *error)
{
    const char *meant = NULL;
    int best = 99;
    for (int c = 0; c < rows->table.n_columns; c++) {
        double value;
        if (mukca_number_parse(&value, name_of(rows, c)))
            return mukca_table_fail(
                error, &rows->table, -1,
                "no column for joint '%s'; the first line must be a header of names", joint);
        if (mukca_chain_find_joint(rows->chain, name_of(rows, c)) < 0 &&
            mukca_suggest_better(&best, joint, name_of(rows, c)))
            meant = name_of(rows, c);
    }
    if (meant)
        return mukca_table_fail(error, &rows->table, -1,
                                "no column for joint '%s' of the chain; is it '%.40s'?", joint,
                                meant);
    return mukca_table_fail(error, &rows->table, -1,
                            "no column for joint '%s' of the chain; is it another robot's file?",
                            joint);
}

/* Column "<joint>.<suffix>", -1 where absent; sets *any where present. */
static int suffixed(const mukca_rows *rows, const char *joint, const char *suffix, bool *any)
{
    char name[MUKCA_NAME_SIZE + 16];
    snprintf(name, sizeof name, "%s.%s", joint, suffix);
    int column = mukca_table_find(&rows->table, name);
    *any |= column >= 0;
    return column;
}

/* All names of a group or none. */
static mukca_status find_group(int *columns, const char *const *names, int n,
                               const mukca_rows *rows, mukca_error *error)
{
    int found = 0;
    const char *absent = NULL;
    for (int i = 0; i < n; i++) {
        columns[i] = mukca_table_find(&rows->table, names[i]);
        found += columns[i] >= 0;
        if (columns[i] < 0) absent = names[i];
    }
    if (found == 0 || found == n) return MUKCA_OK;
    return mukca_table_fail(error, &rows->table, -1, "no column '%s' beside its fellows", absent);
}

/* "<joint>.spread", which `mukca capture` writes, is known and not needed. */
static bool is_spread(const mukca_rows *rows, int c)
{
    char name[MUKCA_NAME_SIZE];
    const char *dot = strrchr(name_of(rows, c), '.');
    if (!dot || strcmp(dot, ".spread") != 0) return false;
    snprintf(name, sizeof name, "%.*s", (int)(dot - name_of(rows, c)), name_of(rows, c));
    return mukca_chain_find_joint(rows->chain, name) >= 0;
}

static bool is_known(const mukca_rows *rows, int c)
{
    const char *dot = strrchr(name_of(rows, c), '.');
    if (dot && strcmp(dot, ".spread") == 0) return true; /* mukca capture's record of its windows */
    const int single[] = {rows->placement, rows->socket, rows->time, rows->temperature,
                          rows->payload};
    for (size_t i = 0; i < sizeof single / sizeof *single; i++)
        if (single[i] == c) return true;
    for (int j = 0; j < rows->chain->n_joints; j++)
        if (rows->joint[j] == c || rows->effort[j] == c || rows->command[j] == c ||
            rows->velocity[j] == c)
            return true;
    if (is_spread(rows, c)) return true;
    for (int i = 0; i < 4; i++)
        if (rows->quaternion[i] == c || (i < 3 && rows->position[i] == c)) return true;
    return false;
}

static void note_extra_columns(const mukca_rows *rows)
{
    char list[120] = "", text[256];
    int extra = 0;
    for (int c = 0; c < rows->table.n_columns; c++) {
        if (is_known(rows, c)) continue;
        size_t used = strlen(list);
        if (used + strlen(name_of(rows, c)) + 8 < sizeof list)
            snprintf(list + used, sizeof list - used, "%s%s", extra ? ", " : "", name_of(rows, c));
        else if (used < 3 || strcmp(list + used - 3, "...") != 0)
            snprintf(list + used, sizeof list - used, ", ...");
        extra++;
    }
    if (!extra || !rows->note) return;
    snprintf(text, sizeof text, "%s: %d column%s unknown and ignored: %s",
             mukca_table_short_path(rows->table.path), extra, extra > 1 ? "s are" : " is", list);
    rows->note(rows->context, text);
}

/* Angles that a driver corrected before it published them (`mukca capture --stream corrected`). */
static void note_corrected(const mukca_rows *rows)
{
    char text[256];
    if (!rows->note || !strstr(rows->table.comments, "# stream: corrected\n")) return;
    snprintf(text, sizeof text,
             "%s: the stream was corrected by its driver already; what is found here comes on top",
             mukca_table_short_path(rows->table.path));
    rows->note(rows->context, text);
}

static mukca_status map_header(mukca_rows *rows, mukca_error *error)
{
    static const char *const position[] = {"x_m", "y_m", "z_m"};
    static const char *const quaternion[] = {"qw", "qx", "qy", "qz"};
    const mukca_table *t = &rows->table;
    rows->placement = mukca_table_find(t, "placement");
    rows->socket = mukca_table_find(t, "socket");
    rows->time = mukca_table_find(t, "time_s");
    rows->temperature = mukca_table_find(t, "temperature_c");
    rows->payload = mukca_table_find(t, "payload_kg");
    for (int j = 0; j < rows->chain->n_joints; j++) {
        const char *name = rows->chain->element[rows->chain->joint_element[j]].name;
        rows->joint[j] = mukca_table_find(t, name);
        if (rows->joint[j] < 0) return missing_joint(rows, name, error);
        rows->effort[j] = suffixed(rows, name, "effort", &rows->has_effort);
        rows->command[j] = suffixed(rows, name, "command", &rows->has_command);
        rows->velocity[j] = suffixed(rows, name, "velocity", &rows->has_velocity);
    }
    mukca_status status = find_group(rows->position, position, 3, rows, error);
    if (status == MUKCA_OK) status = find_group(rows->quaternion, quaternion, 4, rows, error);
    if (status == MUKCA_OK) note_extra_columns(rows);
    if (status == MUKCA_OK) note_corrected(rows);
    return status;
}

static void map_plain(mukca_rows *rows)
{
    rows->placement = rows->socket = rows->time = rows->temperature = rows->payload = -1;
    for (int j = 0; j < MUKCA_MAX_JOINTS; j++) {
        rows->joint[j] = j;
        rows->effort[j] = rows->command[j] = rows->velocity[j] = -1;
    }
    for (int i = 0; i < 4; i++) rows->quaternion[i] = -1;
    for (int i = 0; i < 3; i++) rows->position[i] = -1;
}

mukca_status mukca_rows_open(mukca_rows *rows, const char *path, mukca_table_kind kind,
                             const mukca_chain *chain, mukca_note_fn *note, void *context,
                             mukca_error *error)
{
    memset(rows, 0, sizeof *rows);
    rows->chain = chain;
    rows->note = note;
    rows->context = context;
    mukca_status status = mukca_table_open(&rows->table, path, kind, error);
    if (status) return status;
    if (rows->table.header)
        status = map_header(rows, error);
    else
        map_plain(rows);
    if (status) mukca_rows_close(rows);
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
    bool linear = e->type == MUKCA_PRISMATIC;
    if (!linear && fabs(q) > most_angle)
        return mukca_table_fail(
            error, &rows->table, rows->joint[j],
            "%g is more than two turns and looks like degrees; joint '%s' needs rad", q, e->name);
    if (linear && fabs(q) > most_prismatic)
        return mukca_table_fail(error, &rows->table, rows->joint[j],
                                "%g looks like millimetres; joint '%s' needs m", q, e->name);
    double beyond = q > e->upper ? q - e->upper : q < e->lower ? e->lower - q : 0;
    if (beyond > limit_tolerance && !rows->warned[j] && rows->note) {
        char text[256];
        snprintf(text, sizeof text, "%s:%d: joint '%s' is %.3g %s beyond its limits",
                 mukca_table_short_path(rows->table.path), rows->table.line, e->name, beyond,
                 linear ? "m" : "rad");
        rows->note(rows->context, text);
        rows->warned[j] = true;
    }
    return MUKCA_OK;
}

bool mukca_rows_normalise(double quaternion[4])
{
    double square = 0;
    for (int i = 0; i < 4; i++) square += quaternion[i] * quaternion[i];
    double length = sqrt(square);
    if (!(fabs(length - 1) <= 0.01)) return false;
    for (int i = 0; i < 4; i++) quaternion[i] /= length;
    return true;
}

static mukca_status read_pose(mukca_row *row, const mukca_rows *rows, mukca_error *error)
{
    mukca_status status = MUKCA_OK;
    int missing = 0;
    for (int i = 0; i < 3 && status == MUKCA_OK; i++) {
        status = read_optional(&row->position[i], rows, rows->position[i], error);
        missing += isnan(row->position[i]) != 0;
        if (status == MUKCA_OK && fabs(row->position[i]) > most_length)
            status =
                mukca_table_fail(error, &rows->table, rows->position[i],
                                 "%g looks like millimetres; positions are in m", row->position[i]);
    }
    if (status == MUKCA_OK && missing % 3 != 0)
        status = mukca_table_fail(error, &rows->table, -1, "a position needs x_m, y_m and z_m");
    missing = 0;
    for (int i = 0; i < 4 && status == MUKCA_OK; i++) {
        status = read_optional(&row->quaternion[i], rows, rows->quaternion[i], error);
        missing += isnan(row->quaternion[i]) != 0;
    }
    if (status || missing == 4) return status;
    if (missing || !mukca_rows_normalise(row->quaternion))
        return mukca_table_fail(error, &rows->table, rows->quaternion[0],
                                "the quaternion's length is not 1 (order: qw qx qy qz)");
    return MUKCA_OK;
}

mukca_status mukca_rows_next(mukca_rows *rows, mukca_row *row, bool *more, mukca_error *error)
{
    const mukca_table *t = &rows->table;
    const int n = rows->chain->n_joints;
    mukca_status status = mukca_table_next(&rows->table, more, error);
    if (status || !*more) return status;
    if (!t->header && t->n_columns != n)
        return mukca_table_fail(error, t, -1,
                                "%d columns, but the chain has %d joints; check --urdf and --tip",
                                t->n_columns, n);
    row->placement = rows->placement < 0 ? NULL : t->cell[rows->placement];
    row->socket = rows->socket < 0 ? NULL : t->cell[rows->socket];
    for (int j = 0; j < n; j++) {
        status = mukca_table_number(&row->q[j], t, rows->joint[j], error);
        if (status == MUKCA_OK) status = check_joint(rows, j, row->q[j], error);
        if (status == MUKCA_OK)
            status = read_optional(&row->effort[j], rows, rows->effort[j], error);
        if (status == MUKCA_OK)
            status = read_optional(&row->command[j], rows, rows->command[j], error);
        if (status == MUKCA_OK)
            status = read_optional(&row->velocity[j], rows, rows->velocity[j], error);
        if (status) return status;
    }
    status = read_optional(&row->time, rows, rows->time, error);
    if (status == MUKCA_OK)
        status = read_optional(&row->temperature, rows, rows->temperature, error);
    if (status == MUKCA_OK) status = read_optional(&row->payload, rows, rows->payload, error);
    if (status == MUKCA_OK) status = read_pose(row, rows, error);
    return status;
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
