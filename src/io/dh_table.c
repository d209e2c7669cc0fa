/* Denavit-Hartenberg tables from files. */
#include "io/urdf.h"

#include <string.h>

#include "base/file.h"
#include "base/number.h"
#include "io/table.h"

enum { JOINT, A, ALPHA, D, THETA, TYPE, LOWER, UPPER, COLUMNS };

/* Accepted names of the columns; the first four numbers are required. */
static const char *const names[COLUMNS][2] = {
    {"joint", NULL},        {"a", "a_m"},   {"alpha", "alpha_rad"}, {"d", "d_m"},
    {"theta", "theta_rad"}, {"type", NULL}, {"lower", NULL},        {"upper", NULL}};

/* Largest angle, rad: a turn and a half.  A table in degrees has larger ones. */
static const double largest_angle = 9.5;

/* Largest length a, m: no arm has that reach, and a table in mm has larger ones.  d is unbounded:
 * nearly parallel axes can meet their common normal anywhere. */
static const double largest_a = 50;

static void read_header(int column[COLUMNS], mukca_table *table)
{
    for (int i = 0; i < COLUMNS; i++) {
        column[i] = mukca_table_use(table, names[i][0]);
        if (column[i] < 0 && names[i][1]) column[i] = mukca_table_use(table, names[i][1]);
    }
    for (int c = 0; c < table->n_columns; c++)
        if (!table->used[c])
            mukca_table_fail(table, c,
                             "unknown column; a table has joint, a, alpha, d, theta, and may have "
                             "type, lower and upper, in m and rad");
    for (int i = 0; i <= THETA; i++)
        if (column[i] < 0)
            mukca_table_fail(table, -1, "the header has no column '%s'", names[i][0]);
}

/* Parse a multiple of pi: pi, -pi/2, 3*pi/4. */
static bool parse_pi(double *value, const char *cell)
{
    double factor = 1, divisor = 1;
    char text[16] = "";
    const char *pi = strstr(cell, "pi"), *rest = pi ? pi + 2 : NULL;
    const size_t before = pi ? (size_t)(pi - cell) : sizeof text;
    if (before >= sizeof text) return false;
    memcpy(text, cell, before);
    if (before > 0 && text[before - 1] == '*') text[before - 1] = '\0';
    const bool sign = strcmp(text, "-") == 0 || strcmp(text, "+") == 0;
    if (sign) factor = *text == '-' ? -1 : 1;
    if (!sign && *text && !mukca_number_parse(&factor, text)) return false;
    if (*rest && (*rest != '/' || !mukca_number_parse(&divisor, rest + 1))) return false;
    *value = factor * 3.14159265358979323846 / divisor;
    return isfinite(*value) != 0;
}

/* Read a number whose unit is `unit` m or rad, with magnitude at most `most`. */
static double read_number(mukca_table *table, int column, double unit, double most)
{
    double value;
    if (!parse_pi(&value, table->cell[column])) value = unit * mukca_table_number(table, column);
    if (!(fabs(value) <= most))
        mukca_table_fail(table, column,
                         "%s is out of range; lengths are in m, angles in rad, or see --units",
                         table->cell[column]);
    return value;
}

static void read_name(mukca_dh_row *row, const mukca_dh *dh, mukca_table *table, int column)
{
    const char *name = table->cell[column];
    if (!*name || strlen(name) >= MUKCA_NAME_SIZE)
        mukca_table_fail(table, column, "the name of a joint has 1 to 63 characters");
    else
        memcpy(row->name, name, strlen(name) + 1);
    for (int k = 0; k < dh->n_rows; k++)
        if (strcmp(dh->row[k].name, name) == 0)
            mukca_table_fail(table, column, "joint '%s' has a row already", name);
}

static mukca_joint_type read_type(mukca_table *table, int column)
{
    if (column < 0 || !table->cell[column][0]) return MUKCA_REVOLUTE;
    for (int type = MUKCA_FIXED; type <= MUKCA_PRISMATIC; type++)
        if (strcmp(table->cell[column], mukca_joint_type_name[type]) == 0)
            return (mukca_joint_type)type;
    mukca_table_fail(table, column, "unknown type; use revolute, continuous, prismatic or fixed");
    return MUKCA_REVOLUTE;
}

/* Context of a row. */
typedef struct {
    mukca_table *table;
    int column[COLUMNS];
    double angle, length; /* rad and m per unit of columns without a unit in their name */
} reader;

static void read_row(mukca_dh_row *row, const mukca_dh *dh, const reader *r)
{
    mukca_table *table = r->table;
    double *const number[COLUMNS] = {
        [A] = &row->a,         [ALPHA] = &row->alpha, [D] = &row->d,
        [THETA] = &row->theta, [LOWER] = &row->lower, [UPPER] = &row->upper};
    *row = (mukca_dh_row){.lower = -HUGE_VAL, .upper = HUGE_VAL};
    read_name(row, dh, table, r->column[JOINT]);
    row->type = read_type(table, r->column[TYPE]);
    for (int i = A; i < COLUMNS; i++) {
        const int c = r->column[i];
        if (!number[i] || c < 0 || (i > THETA && !table->cell[c][0])) continue;
        const bool own =
            strcmp(table->header[c], names[i][0]) != 0 || mukca_table_has_unit(table, c);
        const bool angle = i == ALPHA || i == THETA || (i > THETA && mukca_joint_turns(row->type));
        const double unit = own ? 1 : angle ? r->angle : r->length;
        const double most = i == A                ? largest_a
                            : angle && i <= THETA ? largest_angle
                                                  : MUKCA_NUMBER_LARGEST;
        *number[i] = read_number(table, c, unit, most);
    }
    if (!(row->lower < row->upper))
        mukca_table_fail(table, r->column[UPPER], "is not above the lower limit");
}

static bool read_convention(mukca_dh *dh, const mukca_table *table)
{
    const char *line = strstr(table->comments, "# convention: ");
    if (!line) return false;
    line += strlen("# convention: ");
    dh->convention = strncmp(line, "modified", 8) == 0 ? MUKCA_DH_MODIFIED : MUKCA_DH_STANDARD;
    return true;
}

mukca_status mukca_dh_read(mukca_dh *dh, bool *stated, const char *path,
                           const mukca_rows_format *format, mukca_error *error)
{
    mukca_table table;
    reader r = {.table = &table,
                .angle = format && format->angle > 0 ? format->angle : 1,
                .length = format && format->length > 0 ? format->length : 1};
    const int most = sizeof dh->row / sizeof *dh->row;
    int moving = 0;
    *dh = (mukca_dh){0};
    mukca_table_open(&table, path, MUKCA_HEADER, error);
    if (table.status == MUKCA_OK) read_header(r.column, &table);
    *stated = table.status == MUKCA_OK && read_convention(dh, &table);
    while (mukca_table_next(&table)) {
        if (dh->n_rows == most) {
            mukca_table_fail(&table, -1, "more than %d rows", most);
            break;
        }
        mukca_dh_row *row = &dh->row[dh->n_rows];
        read_row(row, dh, &r);
        dh->n_rows++;
        moving += row->type != MUKCA_FIXED;
        if (moving > MUKCA_MAX_JOINTS)
            mukca_table_fail(&table, -1, "more than %d joints that move", MUKCA_MAX_JOINTS);
    }
    const mukca_status status = mukca_table_close(&table);
    if (status != MUKCA_OK || moving > 0) return status;
    return mukca_fail(error, MUKCA_INPUT, "%s: no joint moves", mukca_file_shown(path));
}
