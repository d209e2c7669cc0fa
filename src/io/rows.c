/* Recorded rows, read and checked one at a time. */
#include "io/rows.h"

#include <math.h>
#include <string.h>

#include "base/file.h"
#include "base/text.h"
#include "io/table.h"
#include "mukca/rotation.h"

/* Larger lengths, m, are in millimetres: no arm has a reach of 50 m. */
static const double most_length = 50;
/* Largest deviation from length 1 of a quaternion written with three decimals. */
static const double length_tolerance = 0.01;

mukca_status mukca_rows_open(mukca_rows *rows, const char *path, const mukca_chain *chain,
                             const mukca_rows_options *options, mukca_error *error)
{
    *rows = (mukca_rows){.chain = chain, .options = *options};
    if (!(rows->options.format.angle > 0)) rows->options.format.angle = 1;
    if (!(rows->options.format.length > 0)) rows->options.format.length = 1;
    mukca_table *t = &rows->table;
    mukca_table_open(t, path,
                     options->poses                     ? MUKCA_HEADER
                     : options->kind == MUKCA_NO_HEADER ? MUKCA_NO_HEADER
                                                        : MUKCA_EITHER,
                     error);
    if (t->status == MUKCA_OK && options->format.columns && t->n_columns)
        mukca_columns_rename(t, options->format.columns);
    if (t->status == MUKCA_OK) mukca_rows_map(rows);
    return t->status == MUKCA_OK ? MUKCA_OK : mukca_rows_close(rows);
}

mukca_status mukca_rows_close(mukca_rows *rows)
{
    if (rows->table.cut_off && rows->table.status == MUKCA_OK)
        mukca_note_format(rows->options.note, rows->options.context,
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
    mukca_note_format(rows->options.note, rows->options.context,
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

bool mukca_rows_normalise(double quaternion[4])
{
    double square = 0;
    for (int i = 0; i < 4; i++) square += quaternion[i] * quaternion[i];
    const double length = sqrt(square);
    if (!(fabs(length - 1) <= length_tolerance)) return false;
    for (int i = 0; i < 4; i++) quaternion[i] /= length;
    return true;
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
        const double product =
            R[3 * a] * R[3 * b] + R[3 * a + 1] * R[3 * b + 1] + R[3 * a + 2] * R[3 * b + 2];
        if (!(fabs(product - (a == b)) <= length_tolerance))
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

/* Replace the pose of the measuring frame in the target's frame by its inverse. */
static void invert_pose(mukca_row *row)
{
    double R[9], p[3];
    mukca_rotation_from_quaternion(R, row->quaternion);
    mukca_mat3_tvec(p, R, row->position);
    for (int i = 0; i < 3; i++) row->position[i] = -p[i], row->quaternion[1 + i] *= -1;
}

/* ---- order of the numbers in recorded quaternions, by the arm's kinematics ----
 *
 * measured = tracker * tip(q) * target.  The rotation between two rows, in the target's frame, is
 * that of the tip in a rotated frame: inner products of two such rotation vectors are independent
 * of the frames.  A cyclic shift of a quaternion's four numbers is an inversion between two fixed
 * rotations.  It preserves angles, and inner products of two rotations with a common row, but not
 * others.  Inverse poses behave alike. */
/* Smaller rotations of the tip contribute little, rad; number of pairs for a verdict; thresholds
 * far above the effect of errors of the nominal arm (some 10 mrad in rotations of 1 rad).  The
 * errors of a wrong order are of the size of the rotations squared. */
static const double least_turn = 0.2, least_error = 0.05, least_ratio = 10;
enum { LEAST_PAIRS = 5, MOST_PAIRS = 40 };

/* Rotation of quaternion[4] in the file's order, or (other) in the other order. */
static void rotation(double R[9], const double quaternion[4], bool other, bool w_last, bool inverse)
{
    double q[4], T[9];
    for (int i = 0; i < 4; i++) /* for w last, x y z w in the file: x would be w */
        q[i] = quaternion[!other ? i : w_last ? (i + 1) % 4 : (i + 3) % 4];
    mukca_rotation_from_quaternion(R, q);
    memcpy(T, R, sizeof T);
    for (int i = 0; i < 9 && inverse; i++) R[i] = T[3 * (i % 3) + i / 3];
}

/* Axis times sine of the rotation from A to B, in the frame of A: antisymmetric part of A' B.
 * Unlike the rotation vector it is continuous at half a turn. */
static void turn_between(double w[3], const double A[9], const double B[9])
{
    for (int i = 0; i < 3; i++) {
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        w[i] = 0;
        for (int r = 0; r < 3; r++)
            w[i] += 0.5 * (A[3 * r + b] * B[3 * r + a] - A[3 * r + a] * B[3 * r + b]);
    }
}

/* Add an orientation as read (w first; `w_last`: it was last in the file; `inverse`: of the fixed
 * frame in the target's).  True if the orientations so far agree with the nominal arm in the other
 * order and disagree in the file's order. */
static bool is_wrong_order(mukca_rows *rows, const mukca_row *row)
{
    const mukca_rows_format *f = &rows->options.format;
    mukca_quaternion_check *o = &rows->quaternions;
    mukca_frame tip;
    double R[3][9], turn[3][3], product[3] = {0};
    if (o->pairs == MOST_PAIRS) return false;
    if (o->n == 0) mukca_geometry_set(&o->geometry, rows->chain, NULL);
    mukca_fk_pose(&tip, &o->geometry, row->q, NULL);
    memcpy(R[0], tip.R, sizeof R[0]);
    for (int k = 0; k < 2; k++) rotation(R[1 + k], row->quaternion, k == 1, f->w_last, f->inverse);
    if (o->n > 0 && mukca_rotation_between(o->last[0], R[0]) < least_turn) return false;
    for (int k = 0; k < 3 && o->n > 0; k++) {
        turn_between(turn[k], o->last[k], R[k]);
        product[k] = mukca_dot3(o->turn[1][k], turn[k]);
    }
    if (o->n > 2) {
        for (int k = 0; k < 2; k++) o->error[k] += fabs(product[1 + k] - product[0]);
        o->pairs++;
    }
    memcpy(o->turn[1], o->turn[0], sizeof turn);
    if (o->n > 0) memcpy(o->turn[0], turn, sizeof turn);
    memcpy(o->last, R, sizeof R);
    o->n++;
    return o->pairs >= LEAST_PAIRS && o->error[0] > least_error * o->pairs &&
           o->error[0] > least_ratio * o->error[1];
}

/* Check the quaternion's order against the arm's kinematics. */
static void check_order(mukca_rows *rows, const mukca_row *row, int column)
{
    const mukca_rows_format *f = &rows->options.format;
    if (is_wrong_order(rows, row))
        mukca_table_fail(
            &rows->table, column,
            "the orientations agree with the arm only as %s or inverse: %s, or %s --inverse-poses",
            f->w_last ? "qw qx qy qz" : "qx qy qz qw",
            !f->by_order ? "correct the columns' names"
            : f->w_last  ? "give --map order"
                         : "give --map order-w-last",
            f->inverse ? "omit" : "give");
}

/* Read the orientation of the columns `turn`; unchanged if the target was not visible. */
static void read_turn(mukca_row *row, mukca_rows *rows, const mukca_measured_columns *m)
{
    double v[4], R[9];
    const int n = m->form == MUKCA_QUATERNION ? 4 : 3;
    const int missing = read_list(v, rows, m->turn, n);
    if (missing == n) return;
    if (n == 4) {
        memcpy(row->quaternion, v, sizeof v);
        return;
    }
    if (missing)
        mukca_table_fail(&rows->table, m->turn[0], "an orientation needs all three numbers");
    for (int i = 0; i < 3; i++) {
        if (!mukca_table_has_unit(&rows->table, m->turn[i])) v[i] *= rows->options.format.angle;
        if (fabs(v[i]) > MUKCA_ROWS_MOST_ANGLE)
            mukca_table_fail(&rows->table, m->turn[i],
                             "is %s; angles are in rad (for degrees: --units deg)",
                             rows->table.cell[m->turn[i]]);
    }
    if (m->form == MUKCA_ROTATION_VECTOR)
        mukca_rotation_exp(R, v);
    else
        mukca_rotation_from_rpy(R, m->form == MUKCA_ABC ? (double[]){v[2], v[1], v[0]} : v);
    mukca_rotation_to_quaternion(row->quaternion, R);
}

static void read_pose(mukca_row *row, mukca_rows *rows, int target)
{
    const mukca_measured_columns *m = &rows->column.measured[target];
    mukca_table *t = &rows->table;
    int missing = 0;
    for (int i = 0; i < 7; i++)
        *(i < 3 ? &row->position[i] : &row->quaternion[i - 3]) = (double)NAN;
    if (target >= rows->column.n_measured) return;
    if (m->target[0]) row->target = m->target;
    if (m->matrix[0] >= 0) {
        read_matrix(row, rows, m);
    } else {
        missing = read_list(row->position, rows, m->position, 3);
        read_turn(row, rows, m);
    }
    for (int i = 0; i < 3; i++) {
        const int column = m->matrix[0] < 0 ? m->position[i] : m->matrix[4 * i + 3];
        if (!mukca_table_has_unit(t, column)) row->position[i] *= m->length;
        mukca_rows_check_length(t, column, row->position[i]);
    }
    if (missing % 3 != 0) mukca_table_fail(t, -1, "a position needs x_m, y_m and z_m");
    bool turned = false;
    for (int i = 0; i < 4; i++) turned |= !isnan(row->quaternion[i]);
    if (turned && !mukca_rows_normalise(row->quaternion))
        mukca_table_fail(t, m->turn[0], "the quaternion's length is not 1 (order: qw qx qy qz)");
    if (turned && target == 0 && m->matrix[0] < 0 && m->form == MUKCA_QUATERNION &&
        !rows->options.any_order && t->status == MUKCA_OK)
        check_order(rows, row, m->turn[0]);
    if (!rows->options.format.inverse || isnan(row->position[0])) return;
    if (turned)
        invert_pose(row);
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
    const bool poses = rows->options.poses;
    if (rows->measured > 0 && rows->measured < c->n_measured) { /* the next target of this line */
        read_pose(row, rows, rows->measured++);
        return t->status == MUKCA_OK;
    }
    rows->measured = 1;
    if (!mukca_table_next(t)) return false;
    if (c->number[MUKCA_COLUMN_Q][0] < 0 && !poses) mukca_rows_map(rows);
    if (t->status != MUKCA_OK) return false;
    row->placement = c->placement < 0 ? NULL : t->cell[c->placement];
    row->socket = c->socket < 0 ? NULL : t->cell[c->socket];
    row->target = c->target < 0 || !*t->cell[c->target] ? NULL : t->cell[c->target];
    for (int k = 0; k < MUKCA_COLUMNS && !poses; k++)
        if (mukca_column_table[k].width < 2)
            read_numbers(row, rows, k);
        else /* of poses: below */
            for (int i = 0; i < mukca_column_table[k].width; i++) row->number[k][i] = (double)NAN;
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
