/* Columns of recorded rows: their meaning by name or by order. */
#include <string.h>

#include "base/file.h"
#include "base/number.h"
#include "base/suggest.h"
#include "io/rows.h"
#include "math/angles.h"

static void fail_header(mukca_rows *rows, const char *joint)
{
    mukca_table *t = &rows->table;
    const char *meant = NULL;
    char names[64] = "";
    int best = 99;
    for (int c = 0; c < t->n_columns; c++) {
        double value;
        if (mukca_number_parse(&value, t->header[c]))
            mukca_table_fail(
                t, -1,
                "no column for joint '%s'; the first line must be a header of names: those of the "
                "joints, and placement and socket, or x_m y_m z_m",
                joint);
        const bool longer = strncmp(joint, t->header[c], strlen(joint)) == 0; /* has a unit */
        if (mukca_chain_find_joint(rows->chain, t->header[c]) < 0 &&
            (mukca_suggest_better(&best, joint, t->header[c]) || (longer && !meant)))
            meant = t->header[c];
    }
    if (meant)
        mukca_table_fail(
            t, -1,
            "no column for joint '%s' of the chain; rename column '%.40s' with --columns "
            "'%.40s=%s'%s",
            joint, meant, meant, joint,
            strstr(meant, "deg") ? ", and give --units deg" : ", or check --urdf and --tip");
    mukca_table_list(&(mukca_text)MUKCA_TEXT(names), t, false);
    mukca_table_fail(t, -1,
                     "no column for joint '%s' (columns: %s); name them with --columns, or check "
                     "--urdf and --tip",
                     joint, names);
}

/* Columns of the header, and how they are named. */
typedef struct {
    mukca_rows *rows;
    mukca_prefix prefix; /* by which the columns' names differ from the joints' */
    int numbered;        /* index in `numbered`, -1: joints by name; then the first one's number */
    int first;
} header;

/* Names of the columns of numbered joints. */
enum { NUMBERED = 8, OF_RTDE = 0 };
static const char *const numbered[NUMBERED] = {"actual_q_", "q_", "q",     "j",
                                               "J",         "A",  "joint", "joint_"};

/* Names by UR's RTDE, with the number of the joint. */
static const char *const rtde[MUKCA_COLUMNS] = {[MUKCA_COLUMN_Q] = "actual_q_",
                                                [MUKCA_COLUMN_COMMAND] = "target_q_",
                                                [MUKCA_COLUMN_VELOCITY] = "actual_qd_",
                                                [MUKCA_COLUMN_TIME] = "timestamp"};

bool mukca_columns_reserved(const char *name)
{
    bool found = strcmp(name, "placement") == 0 || strcmp(name, "socket") == 0 ||
                 strcmp(name, "temperature_c") == 0; /* known, not used */
    for (int c = 0; c < MUKCA_COLUMNS; c++)
        for (int k = 0; k < mukca_column_table[c].width; k++)
            found |= strcmp(name, mukca_column_table[c].name[k]) == 0;
    return found;
}

/* Find column `prefix``suffix`; -1: absent, or it has another meaning: joints come first. */
static int find(header *h, const char *prefix, const char *suffix)
{
    char name[MUKCA_PREFIX_NAME + 16];
    snprintf(name, sizeof name, "%s%s", prefix, suffix);
    const int column = mukca_table_find(&h->rows->table, name);
    return column >= 0 && h->rows->table.used[column] ? -1 : mukca_table_use(&h->rows->table, name);
}

static int find_of_joint(header *h, int joint, const char *suffix)
{
    char name[MUKCA_PREFIX_NAME];
    mukca_prefix_apply(name, &h->prefix, mukca_chain_joint_name(h->rows->chain, joint));
    return find(h, name, suffix);
}

/* Find a column of MUKCA_COLUMN_LIST, of a joint if it has one for each. */
static int find_number(header *h, int column, int joint)
{
    const mukca_column *c = &mukca_column_table[column];
    const char *alias = h->numbered == OF_RTDE                        ? rtde[column]
                        : column == MUKCA_COLUMN_Q && h->numbered > 0 ? numbered[h->numbered]
                                                                      : NULL;
    char number[16];
    if (c->width) return find(h, alias ? alias : c->name[0], "");
    if (!alias) return h->numbered < 0 ? find_of_joint(h, joint, c->name[0]) : -1;
    snprintf(number, sizeof number, "%d", h->first + joint);
    return find(h, alias, number);
}

/* Determine how the columns name the joints: as the chain, with another prefix, or by numbers. */
static void find_names(header *h)
{
    mukca_table *t = &h->rows->table;
    const mukca_chain *chain = h->rows->chain;
    const char *names[MUKCA_MAX_JOINTS];
    const int n = chain->n_joints;
    for (int j = 0; j < n; j++) names[j] = mukca_chain_joint_name(chain, j);
    h->numbered = -1;
    const int found =
        mukca_prefix_find(&h->prefix, names, n, (const char *const *)t->header, t->n_columns);
    if (found > 1)
        mukca_table_fail(t, -1,
                         "the joints' columns have several prefixes, as for several arms; choose "
                         "with --columns, as in '%s%s=%s,...'",
                         h->prefix.add, names[0], names[0]);
    if (found > 0 || n < 2) return;
    for (int i = 0; i < 2 * NUMBERED; i++) {
        char name[32];
        int count = 0;
        for (; count <= n; count++) {
            snprintf(name, sizeof name, "%s%d", numbered[i / 2], i % 2 + count);
            if (mukca_table_find(t, name) < 0) break;
        }
        if (count != n) continue;
        h->numbered = i / 2;
        h->first = i % 2;
        mukca_note_format(h->rows->options.notes,
                          "%s: columns %s%d to %s%d read as the joints %s to %s in this order",
                          mukca_file_shown(t->path), numbered[i / 2], h->first, numbered[i / 2],
                          h->first + n - 1, names[0], names[n - 1]);
        return;
    }
}

/* Find all columns `names``suffix` or none; an incomplete group is an error. */
static void find_group(int *columns, header *h, const char *const *names, int n, const char *suffix)
{
    int found = 0;
    const char *absent = NULL;
    for (int i = 0; i < n; i++) {
        columns[i] = find(h, names[i], suffix);
        found += columns[i] >= 0;
        if (columns[i] < 0) absent = names[i];
    }
    if (found > 0 && found < n)
        mukca_table_fail(&h->rows->table, -1, "no column '%s%s'; %s to %s belong together", absent,
                         suffix, names[0], names[n - 1]);
}

static void note_unknown_columns(header *h)
{
    const mukca_table *t = &h->rows->table;
    for (int c = 0; c < t->n_columns; c++) {
        const char *dot = strrchr(t->header[c], '.');
        t->used[c] |= dot && strcmp(dot, MUKCA_COLUMNS_SPREAD) == 0;
    }
    char names[120] = "";
    const int n = mukca_table_list(&(mukca_text)MUKCA_TEXT(names), t, true);
    if (n)
        mukca_note_format(h->rows->options.notes, "%s: %d unknown column%s ignored: %s",
                          mukca_file_shown(t->path), n, n > 1 ? "s" : "", names);
}

/* Column names of a measured pose; `length`: m per unit, 0: by --units. */
enum { METRES, MILLIMETRES, PLAIN, CAPITAL, RTDE, MATRIX, FORMS };
static const struct {
    const char *names[16];
    int n;
    double length;
} forms[FORMS] = {[METRES] = {{NULL}, 3, 0}, /* names of MUKCA_COLUMN_POSITION */
                  [MILLIMETRES] = {{"x_mm", "y_mm", "z_mm"}, 3, 1e-3},
                  [PLAIN] = {{"x", "y", "z"}, 3, 0},
                  [CAPITAL] = {{"X", "Y", "Z"}, 3, 0},
                  [RTDE] = {{"actual_TCP_pose_0", "actual_TCP_pose_1", "actual_TCP_pose_2"}, 3, 1},
                  [MATRIX] = {{"m00", "m01", "m02", "m03", "m10", "m11", "m12", "m13", "m20", "m21",
                               "m22", "m23"},
                              12,
                              0}};
static const char *const last_row[] = {"m30", "m31", "m32", "m33"};

/* Column names of an orientation, in the order in which they are looked for, next to positions of
 * the form `with`, FORMS: any but RTDE; and their convention, as of UR, URDF and KUKA. */
static const struct {
    const char *form;
    int with;
    const char *names[4];
} turns[] = {{NULL, FORMS, {NULL}}, /* names of MUKCA_COLUMN_QUATERNION */
             {MUKCA_VECTOR, FORMS, {"rx", "ry", "rz"}},
             {"xyz", FORMS, {"roll", "pitch", "yaw"}},
             {"ZYX", CAPITAL, {"A", "B", "C"}},
             {MUKCA_VECTOR, RTDE, {"actual_TCP_pose_3", "actual_TCP_pose_4", "actual_TCP_pose_5"}}};
enum { TURNS = sizeof turns / sizeof *turns };

/* Fail if the header states a unit of something else than `of` (mukca_unit); column -1: none. */
static void expect_unit(mukca_table *t, int column, char of)
{
    if (column >= 0 && mukca_table_has_unit(t, column) && t->unit[column].of != of)
        mukca_table_fail(t, -1, "column '%.40s' has the unit of something else; correct the header",
                         t->header[column]);
}

static void find_turn(mukca_measured_columns *m, header *h, int form, const char *suffix)
{
    for (int k = 0; k < TURNS && m->turn[0] < 0; k++) {
        if (turns[k].with != (form == RTDE ? RTDE : FORMS) && turns[k].with != form) continue;
        const bool quaternion = !turns[k].form;
        m->form = turns[k].form;
        find_group(m->turn, h,
                   quaternion ? mukca_column_table[MUKCA_COLUMN_QUATERNION].name : turns[k].names,
                   quaternion ? 4 : 3, suffix);
        for (int i = 0; i < 3 && !quaternion; i++) expect_unit(&h->rows->table, m->turn[i], 'a');
    }
    mukca_rotations_map(&h->rows->table, m->turn, &m->form, &h->rows->options.format.rotation);
}

/* Find the columns of the target whose first one is `column`, if it has that form. */
static void find_measured(header *h, int column, int form)
{
    mukca_rows *rows = h->rows;
    mukca_row_columns *c = &rows->column;
    const char *const *names =
        forms[form].names[0] ? forms[form].names : mukca_column_table[MUKCA_COLUMN_POSITION].name;
    const char *name = rows->table.header[column], *suffix = name + strlen(names[0]);
    if (strncmp(name, names[0], strlen(names[0])) != 0 || (*suffix && *suffix != '.') ||
        rows->table.used[column] || strlen(suffix) > sizeof c->measured->target)
        return;
    if (c->n_measured == MUKCA_ROWS_TARGETS) {
        mukca_table_fail(&rows->table, column, "more than %d targets in a line",
                         (int)MUKCA_ROWS_TARGETS);
        return;
    }
    mukca_measured_columns *m = &c->measured[c->n_measured++];
    memset(m, -1, sizeof *m);
    m->form = NULL;
    snprintf(m->target, sizeof m->target, "%s", *suffix ? suffix + 1 : "");
    m->length = forms[form].length > 0 ? forms[form].length : rows->options.format.length;
    find_group(form == MATRIX ? m->matrix : m->position, h, names, forms[form].n, suffix);
    for (int k = 0; k < 3; k++)
        expect_unit(&rows->table, form == MATRIX ? m->matrix[4 * k + 3] : m->position[k], 'l');
    if (form == MATRIX)
        find_group(m->matrix + 12, h, last_row, 4, suffix);
    else
        find_turn(m, h, form, suffix);
}

/* Fail if a column's header states the unit of another quantity. */
static void expect(header *h, int column, int k)
{
    const mukca_rows *rows = h->rows;
    const char of = mukca_column_table[column].of;
    const bool slides = mukca_column_table[column].width == 0 &&
                        rows->chain->element[rows->chain->joint_element[k]].type == MUKCA_PRISMATIC;
    if (!slides || of == 'j')
        expect_unit(&h->rows->table, rows->column.number[column][k],
                    of != 'j' ? of
                    : slides  ? 'l'
                              : 'a');
}

/* Find the columns of numbers but those of poses; commanded angles replace absent ones. */
static void map_numbers(header *h)
{
    mukca_rows *rows = h->rows;
    const int n = rows->chain->n_joints;
    int *q = rows->column.number[MUKCA_COLUMN_Q],
        *effort = rows->column.number[MUKCA_COLUMN_EFFORT];
    const int *command = rows->column.number[MUKCA_COLUMN_COMMAND];
    find_names(h);
    for (int c = 0; c < MUKCA_COLUMNS; c++)
        for (int k = 0; k < mukca_column_width(c, n) && mukca_column_table[c].width < 2; k++)
            rows->column.number[c][k] = find_number(h, c, k), expect(h, c, k);
    const bool currents = rows->options.currents && effort[0] < 0;
    for (int j = 0; j < n && currents; j++)
        rows->has_current |= (effort[j] = find_of_joint(h, j, ".current")) >= 0;
    rows->by_command = q[0] < 0 && command[0] >= 0;
    for (int j = 0; j < n; j++) {
        if (rows->by_command) q[j] = command[j];
        if (q[j] < 0) fail_header(rows, mukca_chain_joint_name(rows->chain, j));
        rows->has_command |= command[j] >= 0;
    }
}

static void map_header(mukca_rows *rows)
{
    const mukca_rows_format *format = &rows->options.format;
    mukca_row_columns *c = &rows->column;
    header h = {.rows = rows, .numbered = -1};
    map_numbers(&h);
    c->placement = find(&h, "placement", "");
    c->socket = find(&h, "socket", "");
    c->target = find(&h, "target", "");
    (void)find(&h, "temperature_c", "");
    for (int form = 0; form < FORMS; form++)
        for (int column = 0; column < rows->table.n_columns; column++) {
            if ((form == PLAIN || form == CAPITAL) && !format->units &&
                !mukca_table_has_unit(&rows->table, column))
                continue; /* unit unknown */
            find_measured(&h, column, form);
        }
    if (c->socket >= 0 && c->n_measured > 1)
        c->n_measured = 1; /* a sample of a socket occupies one row */
    if (rows->table.status != MUKCA_OK) return;
    note_unknown_columns(&h);
    /* angles corrected by the driver before publication (mukca capture --stream corrected) */
    if (strstr(rows->table.comments, "# stream: corrected\n"))
        mukca_note_format(rows->options.notes,
                          "%s: the driver has corrected these angles already; offsets found here "
                          "add to its own",
                          mukca_file_shown(rows->table.path));
}

/* Map a table without header: the joints, then the pose in the order implied by its width. */
static void map_order(mukca_rows *rows)
{
    mukca_table *t = &rows->table;
    const mukca_rows_options *o = &rows->options;
    mukca_row_columns *c = &rows->column;
    const int n = rows->chain->n_joints, more = t->n_columns - n;
    const bool poses = more == 3 || more == 7 || more == 12 || more == 16;
    for (int j = 0; j < n; j++) c->number[MUKCA_COLUMN_Q][j] = j;
    if (o->kind == MUKCA_HEADER && poses && !o->format.by_order)
        mukca_table_fail(
            t, -1,
            "has no header; %d columns may be %d joints and %s: name them in the first line, or "
            "confirm that order with --map order%s",
            t->n_columns, n,
            more == 3    ? "x y z"
            : more == 7  ? "x y z qw qx qy qz"
            : more == 12 ? "a 3x4 matrix row by row"
                         : "a 4x4 matrix row by row",
            more == 7 ? ", or --map order-w-last for qx qy qz qw" : "");
    if (o->format.by_order && !poses)
        mukca_table_fail(t, -1,
                         "%d columns; --map order reads %d joints and then 3 (x y z), 7 "
                         "(with a quaternion), 12 or 16 numbers (a 3x4 or 4x4 matrix)",
                         t->n_columns, n);
    if (o->kind == MUKCA_HEADER && !poses)
        mukca_table_fail(t, -1,
                         "starts with numbers; name the columns in the first line or by --columns "
                         "(or give the folder of hole_0.csv and hole_1.csv)");
    if (more != 0 && !(poses && o->format.by_order))
        mukca_table_fail(t, -1, "%d columns, but the chain has %d joints; check --urdf and --tip",
                         t->n_columns, n);
    if (more == 0 || t->status != MUKCA_OK) return;
    mukca_measured_columns *m = &c->measured[c->n_measured++];
    m->target[0] = '\0';
    m->length = o->format.length;
    m->form = NULL;
    for (int i = 0; i < more; i++)
        *(more >= 12 ? &m->matrix[i] : i < 3 ? &m->position[i] : &m->turn[i - 3]) = n + i;
    mukca_rotations_map(t, m->turn, &m->form, &o->format.rotation);
    if (more == 7)
        mukca_note_format(o->notes, "%s: read as %d joints, x y z, %s", mukca_file_shown(t->path),
                          n,
                          strcmp(o->format.rotation.as, "xyzw") == 0
                              ? "qx qy qz qw (w first: --map order)"
                              : "qw qx qy qz (w last: --map order-w-last)");
}

void mukca_rows_map(mukca_rows *rows)
{
    memset(&rows->column, -1, sizeof rows->column);
    rows->column.n_measured = 0;
    if (rows->table.header)
        map_header(rows);
    else if (rows->table.n_columns) /* else at the first row */
        map_order(rows);
}
