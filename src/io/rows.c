/* Recorded rows, read and checked one at a time. */
#include "io/rows.h"

#include <math.h>
#include <string.h>

#include "base/file.h"
#include "base/text.h"
#include "io/table.h"
#include "math/angles.h"
#include "mukca/rotation.h"

/* Larger lengths, m, are in millimetres: no arm has a reach of 50 m. */
static const double most_length = 50;
/* Largest deviation from orthogonal axes of length 1 in a matrix of three decimals. */
static const double length_tolerance = 0.01;

mukca_status mukca_rows_open(mukca_rows *rows, const char *path, const mukca_chain *chain,
                             const mukca_rows_options *options, mukca_error *error)
{
    *rows = (mukca_rows){.chain = chain, .options = *options};
    if (!(rows->options.format.angle > 0)) rows->options.format.angle = 1;
    if (!(rows->options.format.length > 0)) rows->options.format.length = 1;
    mukca_table *t = &rows->table;
    mukca_table_open(t, path, options->kind == MUKCA_NO_HEADER ? MUKCA_NO_HEADER : MUKCA_EITHER,
                     error);
    if (t->status == MUKCA_OK && options->format.columns && t->n_columns)
        mukca_columns_rename(t, options->format.columns);
    if (t->status == MUKCA_OK) mukca_rows_map(rows);
    return t->status == MUKCA_OK ? MUKCA_OK : mukca_rows_close(rows);
}

mukca_status mukca_rows_close(mukca_rows *rows)
{
    if (rows->table.cut_off && rows->table.status == MUKCA_OK)
        mukca_note_format(rows->options.notes,
                          "%s:%d: the last line has no line end; if the file was cut, its last "
                          "number is wrong",
                          mukca_file_shown(rows->table.path), rows->table.line);
    return mukca_table_close(&rows->table);
}

/* An optional number: NaN for a missing column, an empty cell or `nan`. */
static double read_optional(mukca_rows *rows, int column)
{
    const char *text = column < 0 ? "" : rows->table.cell[column];
    if (!*text || strcmp(text, "nan") == 0 || strcmp(text, "NaN") == 0) return (double)NAN;
    return mukca_table_number(&rows->table, column);
}

/* rad or m per unit of a joint's column, if its header states none. */
static double unit_of(const mukca_rows *rows, int joint)
{
    const mukca_chain *chain = rows->chain;
    const mukca_rows_format *f = &rows->options.format;
    return chain->element[chain->joint_element[joint]].type == MUKCA_PRISMATIC ? f->length
                                                                               : f->angle;
}

/* Note a joint's first sample of a kind. */
static void note_joint(mukca_rows *rows, int j, const char *what)
{
    bool *warned = rows->options.warned ? rows->options.warned : rows->warned;
    if (warned[j] || rows->table.status != MUKCA_OK) return;
    mukca_note_format(rows->options.notes,
                      "%s:%d: joint '%s' is %s (only the first such sample is listed)",
                      mukca_file_shown(rows->table.path), rows->table.line,
                      mukca_chain_joint_name(rows->chain, j), what);
    warned[j] = true;
}

/* Check an angle or length.  Angles counted from 0 to a turn are brought within the limits of a
 * joint that has any. */
static double check_joint(mukca_rows *rows, int j, double q)
{
    const mukca_element *e = &rows->chain->element[rows->chain->joint_element[j]];
    const bool linear = e->type == MUKCA_PRISMATIC;
    const double unit = unit_of(rows, j), beyond = mukca_rows_beyond(e, q);
    const double other = q + (q > e->upper ? -2 : 2) * M_PI;
    char what[96];
    if (!mukca_rows_plausible(e, q))
        mukca_table_fail(&rows->table, rows->column.number[MUKCA_COLUMN_Q][j], "joint '%s' is %g%s",
                         e->name, q / unit,
                         linear     ? "; lengths are in m (for millimetres: --units mm)"
                         : unit < 1 ? " degrees, more than two turns"
                                    : ", more than two turns; angles are in rad (for degrees: "
                                      "--units deg)");
    if (beyond == 0) return q;
    const bool turned = !linear && mukca_rows_beyond(e, other) == 0;
    if (turned)
        snprintf(what, sizeof what,
                 "%.4g rad; read as %.4g rad, the same posture within its limits", q, other);
    else
        snprintf(what, sizeof what, "%.3g %s beyond its limits", beyond, linear ? "m" : "rad");
    note_joint(rows, j, what);
    return turned ? other : q;
}

void mukca_rows_check_length(mukca_table *table, int column, double metres)
{
    if (fabs(metres) > most_length)
        mukca_table_fail(table, column, "is %g; positions are in m (for millimetres: --units mm)",
                         metres);
}

/* Read optional numbers of several columns; returns how many are missing. */
static int read_list(double *values, mukca_rows *rows, const int *columns, int n)
{
    int missing = 0;
    for (int i = 0; i < n; i++) {
        values[i] = read_optional(rows, columns[i]);
        missing += isnan(values[i]) != 0;
    }
    return missing;
}

/* Read the pose of a 4x4 matrix; unchanged if the target was not visible. */
static void read_matrix(mukca_row *row, mukca_rows *rows, const mukca_measured_columns *m)
{
    mukca_table *t = &rows->table;
    double T[16] = {[15] = 1}, R[9];
    const int n = m->matrix[12] < 0 ? 12 : 16, missing = read_list(T, rows, m->matrix, n);
    if (missing == n) return;
    if (missing) mukca_table_fail(t, m->matrix[0], "a pose needs all numbers of its matrix");
    for (int c = 0; c < 4; c++)
        if (!(fabs(T[12 + c] - (c == 3)) <= 1e-6)) /* the last row is 0 0 0 1 within rounding */
            mukca_table_fail(t, m->matrix[12 + c],
                             "the last row of the matrix is not 0 0 0 1; the 16 numbers must be in "
                             "row-major order");
    for (int i = 0; i < 3; i++) {
        row->position[i] = T[4 * i + 3];
        for (int k = 0; k < 3; k++) R[3 * i + k] = T[4 * i + k];
    }
    for (int i = 0; i < 9; i++) { /* the inverse of a rotation is its transpose */
        const int a = i / 3, b = i % 3;
        if (!(fabs(mukca_dot3(R + 3 * a, R + 3 * b) - (a == b)) <= length_tolerance))
            mukca_table_fail(
                t, m->matrix[0],
                "the matrix contains no rotation; its numbers must be in row-major order");
    }
    double third[3];
    mukca_cross(third, R, R + 3);
    if (mukca_dot3(third, R + 6) < 0)
        mukca_table_fail(t, m->matrix[0],
                         "the axes of the matrix are left-handed; turn the sign of one of them");
    mukca_rotation_to_quaternion(row->quaternion, R);
}

/* Read the orientation of the columns `turn`, and its numbers from left to right; unchanged if the
 * target was not visible. */
static void read_turn(mukca_row *row, double raw[4], mukca_rows *rows,
                      const mukca_measured_columns *m)
{
    double v[4], R[9];
    const int n = m->form ? 3 : 4, missing = read_list(v, rows, m->turn, n);
    if (missing == n) return;
    if (missing && n == 3)
        mukca_table_fail(&rows->table, m->turn[0], "an orientation needs all three numbers");
    for (int i = 0; i < 3 && n == 3; i++) {
        if (!mukca_table_has_unit(&rows->table, m->turn[i])) v[i] *= rows->options.format.angle;
        if (fabs(v[i]) > MUKCA_ROWS_MOST_ANGLE)
            mukca_table_fail(
                &rows->table, m->turn[i],
                "is %s; angles are in rad (for degrees: [deg] after the names of these "
                "columns, or --units deg if the joints are in degrees, too)",
                rows->table.cell[m->turn[i]]);
    }
    for (int i = 0; i < n; i++) {
        int rank = 0;
        for (int k = 0; k < n; k++) rank += m->turn[k] < m->turn[i];
        raw[rank] = v[i];
    }
    if (n == 3) mukca_angles_to_rotation(R, v, m->form);
    if (n == 3) mukca_rotation_to_quaternion(v, R);
    memcpy(row->quaternion, v, sizeof v);
}

/* Keep a pose for the check of the orientations. */
static void keep_rotation(mukca_rows *rows, const mukca_row *row, const double raw[4])
{
    const mukca_measured_columns *m = rows->column.measured;
    const double *x = row->position, *q = row->quaternion;
    if (rows->options.unchecked || rows->table.status != MUKCA_OK) return;
    if (!rows->rotations) {
        rows->rotations = MUKCA_TAKE(&rows->table.pool, mukca_rotation_samples, 1);
        if (!rows->rotations) {
            mukca_table_stop(&rows->table,
                             mukca_fail(rows->table.error, MUKCA_MEMORY, "out of memory"));
            return;
        }
        rows->rotations->form = rows->options.format.rotation;
        rows->rotations->inverse = rows->options.format.inverse;
        rows->rotations->column = m->matrix[0] >= 0 ? m->matrix[0] : m->turn[0];
        rows->rotations->numbers = m->matrix[0] >= 0 ? 0 : m->form ? 3 : 4;
        mukca_rotations_start(rows->rotations, rows->chain);
    }
    mukca_rotations_keep(rows->rotations, row->q,
                         (double[]){x[0], x[1], x[2], q[0], q[1], q[2], q[3]}, raw, row->target);
}

static void read_pose(mukca_row *row, mukca_rows *rows, int target)
{
    const mukca_measured_columns *m = &rows->column.measured[target];
    mukca_table *t = &rows->table;
    double raw[4] = {0};
    int missing = 0;
    for (int i = 0; i < 7; i++)
        *(i < 3 ? &row->position[i] : &row->quaternion[i - 3]) = (double)NAN;
    if (target >= rows->column.n_measured) return;
    if (m->target[0]) row->target = m->target;
    if (m->matrix[0] >= 0) {
        read_matrix(row, rows, m);
    } else {
        missing = read_list(row->position, rows, m->position, 3);
        read_turn(row, raw, rows, m);
    }
    for (int i = 0; i < 3; i++) {
        const int column = m->matrix[0] < 0 ? m->position[i] : m->matrix[4 * i + 3];
        if (!mukca_table_has_unit(t, column)) row->position[i] *= m->length;
        mukca_rows_check_length(t, column, row->position[i]);
    }
    if (missing % 3 != 0) mukca_table_fail(t, -1, "a position needs x_m, y_m and z_m");
    bool turned = false;
    for (int i = 0; i < 4; i++) turned |= !isnan(row->quaternion[i]);
    if (turned && !mukca_rotations_normalise(row->quaternion))
        mukca_table_fail(t, m->turn[0], "the quaternion's length is not 1 (order: qw qx qy qz)");
    if (turned && target == 0) keep_rotation(rows, row, raw);
    if (turned) mukca_rotations_convert(row->quaternion, &rows->options.format.rotation);
    if (!rows->options.format.inverse || isnan(row->position[0])) return;
    if (turned)
        mukca_rotations_invert(row->position, row->quaternion);
    else
        mukca_table_fail(t, -1, "--inverse-poses needs orientations");
}

/* Read a column of MUKCA_COLUMN_LIST, and check it. */
static void read_numbers(mukca_row *row, mukca_rows *rows, int column)
{
    const mukca_column *c = &mukca_column_table[column];
    const int *at = rows->column.number[column];
    for (int k = 0; k < mukca_column_width(column, rows->chain->n_joints); k++) {
        double *value = &row->number[column][k];
        *value = column == MUKCA_COLUMN_Q ? mukca_table_number(&rows->table, at[k])
                                          : read_optional(rows, at[k]);
        if ((c->of == 'j' || c->of == 'r') && at[k] >= 0 &&
            !mukca_table_has_unit(&rows->table, at[k]))
            *value *= unit_of(rows, k);
        if (c->of == 'j' && (column == MUKCA_COLUMN_Q || !isnan(*value)))
            *value = check_joint(rows, k, *value);
        if (column == MUKCA_COLUMN_PAYLOAD && (*value < 0 || *value > MUKCA_ROWS_MOST_PAYLOAD))
            mukca_table_fail(&rows->table, at[k], "%g is no mass in kg", *value);
    }
}

bool mukca_rows_next(mukca_rows *rows, mukca_row *row)
{
    mukca_table *t = &rows->table;
    const mukca_row_columns *c = &rows->column;
    if (rows->measured > 0 && rows->measured < c->n_measured) { /* the next target of this line */
        read_pose(row, rows, rows->measured++);
        return t->status == MUKCA_OK;
    }
    rows->measured = 1;
    if (!mukca_table_next(t)) {
        if (rows->rotations) mukca_rotations_judge(t, rows->rotations, rows->options.notes);
        return false;
    }
    if (c->number[MUKCA_COLUMN_Q][0] < 0) mukca_rows_map(rows);
    if (t->status != MUKCA_OK) return false;
    row->placement = c->placement < 0 ? NULL : t->cell[c->placement];
    row->socket = c->socket < 0 ? NULL : t->cell[c->socket];
    row->target = c->target < 0 || !*t->cell[c->target] ? NULL : t->cell[c->target];
    for (int k = 0; k < MUKCA_COLUMNS; k++)
        if (mukca_column_table[k].width < 2) read_numbers(row, rows, k); /* others are of poses */
    read_pose(row, rows, 0);
    return t->status == MUKCA_OK;
}

mukca_row_reading mukca_row_read(const mukca_row *row, const mukca_rows *rows)
{
    return (mukca_row_reading){.q = row->q,
                               .command = rows->has_command ? row->command : NULL,
                               .time = row->time[0],
                               .payload_kg = row->payload[0],
                               .placement = -1,
                               .number = rows->table.row};
}
