/* Joint states as lines of text: buffering, CSV, and the output of `ros2 topic echo --csv`. */
#include "record/joint_lines.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/cells.h"
#include "base/clock.h"
#include "base/number.h"

void mukca_joint_lines_open(mukca_joint_lines *lines, int fd)
{
    struct stat info;
    memset(lines, 0, sizeof *lines);
    lines->fd = fd;
    lines->file = fstat(fd, &info) == 0 && S_ISREG(info.st_mode);
    lines->format = "lines";
}

/* ---- lines from a descriptor ---- */

void mukca_joint_lines_fill(mukca_joint_lines *l)
{
    memmove(l->buffer, l->buffer + l->start, l->used - l->start);
    l->used -= l->start;
    l->start = 0;
    const size_t room = sizeof l->buffer - l->used - 1;
    const ssize_t n = room ? read(l->fd, l->buffer + l->used, room) : 1;
    if (room && n > 0) l->used += (size_t)n;
    l->arrived = mukca_clock_wall();
    l->ended = n == 0 || (n < 0 && errno != EINTR && errno != EAGAIN);
}

/* A line longer than the buffer is discarded up to its end. */
const char *mukca_joint_lines_peek(mukca_joint_lines *l)
{
    for (;;) {
        char *line = l->buffer + l->start;
        char *end = memchr(line, '\n', l->used - l->start);
        if (!end && l->ended && l->start < l->used) end = l->buffer + l->used;
        if (!end && l->used - l->start == sizeof l->buffer - 1) {
            l->start = l->used = 0;
            l->overlong = true;
        }
        if (!end) return NULL;
        *end = '\0';
        if (!l->overlong) return line;
        l->overlong = false;
        mukca_joint_lines_take(l);
    }
}

void mukca_joint_lines_take(mukca_joint_lines *l)
{
    l->start += strlen(l->buffer + l->start) + 1;
    if (l->start > l->used) l->start = l->used; /* the last line may lack its end */
    l->number++;
}

/* ---- cells ---- */

/* Parse a number; NaN for an empty cell, `nan` or `inf`.  False, with NaN: not a number. */
static bool read_cell(double *value, const char *cell)
{
    *value = (double)NAN;
    if (!*cell || strcmp(cell, "nan") == 0 || strcmp(cell, "NaN") == 0) return true;
    if (strcmp(cell, "inf") == 0 || strcmp(cell, "-inf") == 0) return true;
    if (mukca_number_parse(value, cell)) return true;
    *value = (double)NAN;
    return false;
}

void mukca_joint_lines_clear(mukca_lcm_joints *joints, int n)
{
    joints->time = 0;
    joints->guided = false;
    joints->n = n;
    memset(joints->has, 0, sizeof joints->has);
    for (int r = 0; r < MUKCA_LCM_ROLES; r++)
        for (int j = 0; j < n; j++) joints->value[r][j] = (double)NAN;
}

static void store(mukca_lcm_joints *joints, int role, int joint, double value)
{
    joints->value[role][joint] = value;
    joints->has[role] |= isfinite(value);
}

bool mukca_joint_lines_classify(mukca_line_column *column, mukca_joint_lines *l, char *name)
{
    static const struct {
        const char *name;
        double unit;
    } times[] = {{"time_s", 1e6}, {"time", 1e6}, {"timestamp", 1e6}, {"utime", 1}};
    static const char *const others[] = {"placement", "socket", "target", "temperature_c",
                                         "payload_kg"};
    static const struct {
        const char *suffix;
        int role;
    } suffixes[] = {{".velocity", MUKCA_LCM_ROLE_VELOCITY},
                    {".effort", MUKCA_LCM_ROLE_EFFORT},
                    {".command", MUKCA_LCM_ROLE_COMMAND},
                    {".spread", -1}};
    *column = (mukca_line_column){.role = -1};
    for (int i = 0; i < 4; i++)
        if (strcmp(name, times[i].name) == 0) {
            *column = (mukca_line_column){MUKCA_LCM_ROLE_TIME, 0, times[i].unit};
            return true;
        }
    for (int i = 0; i < 5; i++)
        if (strcmp(name, others[i]) == 0) return true;
    column->role = MUKCA_LCM_ROLE_POSITION;
    char *dot = strrchr(name, '.');
    for (int i = 0; dot && i < 4; i++)
        if (strcmp(dot, suffixes[i].suffix) == 0) {
            column->role = suffixes[i].role;
            *dot = '\0';
            break;
        }
    while (column->joint < l->n_joints && strcmp(l->joint[column->joint], name) != 0)
        column->joint++;
    if (column->joint == MUKCA_LCM_MAX_JOINTS) return false;
    if (column->joint == l->n_joints) l->joint[l->n_joints++] = name;
    return true;
}

/* ---- CSV ---- */

/* Whether a line has at least two cells, all of them names: none empty, none a number. */
static bool is_header(char *const *cell, int n)
{
    for (int i = 0; i < n; i++) {
        double value;
        if (read_cell(&value, cell[i])) return false;
    }
    return n > 1;
}

static mukca_line_kind read_header(mukca_joint_lines *l, const char *line, int n,
                                   mukca_error *error)
{
    memcpy(l->header, line, strlen(line) + 1);
    mukca_cells_split(l->cell, n, l->header, l->delimiter);
    l->n_columns = n;
    l->n_joints = 0;
    for (int i = 0; i < n; i++)
        if (!mukca_joint_lines_classify(&l->column[i], l, l->cell[i])) {
            l->n_columns = 0;
            mukca_fail(error, MUKCA_INPUT, "more than %d joints", (int)MUKCA_LCM_MAX_JOINTS);
            return MUKCA_LINE_FAULT;
        }
    return MUKCA_LINE_NONE;
}

static mukca_line_kind read_row(mukca_lcm_joints *joints, mukca_joint_lines *l, int n,
                                mukca_error *error)
{
    if (n != l->n_columns) {
        mukca_fail(error, MUKCA_INPUT, "%d columns, but %d in the header", n, l->n_columns);
        return MUKCA_LINE_FAULT;
    }
    mukca_joint_lines_clear(joints, l->n_joints);
    joints->has[MUKCA_LCM_ROLE_NAME] = true;
    memcpy(joints->name, l->joint, sizeof joints->name);
    for (int i = 0; i < n; i++) {
        const mukca_line_column *c = &l->column[i];
        double value;
        if (c->role < 0) continue;
        (void)read_cell(&value, l->cell[i]); /* the recorder checks the arm's joints */
        if (c->role == MUKCA_LCM_ROLE_TIME)
            joints->time = isfinite(value) && fabs(value * c->unit) < 9e18
                               ? (int64_t)llround(value * c->unit)
                               : 0;
        else
            store(joints, c->role, c->joint, value);
    }
    l->format = "CSV";
    return MUKCA_LINE_JOINTS;
}

/* ---- ros2 topic echo --csv ---- */

/* Parse an integer that consists of digits only. */
static bool read_count(int64_t *value, const char *cell)
{
    double number;
    const size_t length = strlen(cell);
    if (!length || length > 15 || strspn(cell, "0123456789") != length) return false;
    if (!mukca_number_parse(&number, cell)) return false;
    *value = (int64_t)number;
    return true;
}

/* Parse sec, nanosec, frame, then names, positions, velocities and efforts of
 * sensor_msgs/JointState; an empty array is one empty cell (message_to_csv of rosidl_runtime_py).
 * False: not such a line. */
static bool read_ros(mukca_lcm_joints *joints, const mukca_joint_lines *l, int n)
{
    static const mukca_lcm_role arrays[] = {MUKCA_LCM_ROLE_POSITION, MUKCA_LCM_ROLE_VELOCITY,
                                            MUKCA_LCM_ROLE_EFFORT};
    enum { FIRST = 3 };
    int64_t seconds, nanoseconds;
    double value;
    if (n < FIRST + 4 || !read_count(&seconds, l->cell[0]) || !read_count(&nanoseconds, l->cell[1]))
        return false;
    int names = 0, at = FIRST;
    while (at < n && !read_cell(&value, l->cell[at])) at++, names++;
    if (!names || names > MUKCA_LCM_MAX_JOINTS || seconds > INT32_MAX) return false;
    mukca_joint_lines_clear(joints, names);
    joints->time = 1000000 * seconds + nanoseconds / 1000;
    joints->has[MUKCA_LCM_ROLE_NAME] = true;
    for (int j = 0; j < names; j++) joints->name[j] = l->cell[FIRST + j];
    for (int a = 0; a < 3; a++) {
        /* one joint: an empty cell is an empty array or an unknown value; both mean the same */
        const bool empty = at < n && !*l->cell[at];
        const int count = empty ? 1 : names;
        if (at + count > n) return false;
        for (int j = 0; j < count && !empty; j++) {
            if (!read_cell(&value, l->cell[at + j])) return false;
            store(joints, arrays[a], j, value);
        }
        at += count;
    }
    return at == n;
}

mukca_line_kind mukca_joint_lines_parse_cells(mukca_lcm_joints *joints, mukca_joint_lines *l,
                                              const char *line, mukca_error *error)
{
    if (!*line || *line == '#') return MUKCA_LINE_NONE;
    memcpy(l->text, line, strlen(line) + 1);
    const char delimiter = mukca_cells_delimiter(line);
    const int n = mukca_cells_count(line, delimiter);
    if (n > MUKCA_JOINT_LINES_CELLS) {
        mukca_fail(error, MUKCA_INPUT, "%d cells; at most %d are read", n,
                   (int)MUKCA_JOINT_LINES_CELLS);
        return MUKCA_LINE_FAULT;
    }
    mukca_cells_split(l->cell, n, l->text, delimiter);
    if (read_ros(joints, l, n)) {
        l->format = "ros2 topic echo";
        return MUKCA_LINE_JOINTS;
    }
    if (is_header(l->cell, n)) {
        l->delimiter = delimiter;
        return read_header(l, line, n, error);
    }
    if (l->n_columns && delimiter == l->delimiter) return read_row(joints, l, n, error);
    double value;
    if (n > 1 && read_cell(&value, l->cell[n - 1]) && read_cell(&value, l->cell[0]))
        mukca_fail(error, MUKCA_INPUT,
                   "neither a row under a header of names nor a whole message of `ros2 topic echo "
                   "--csv`");
    else
        mukca_fail(error, MUKCA_INPUT, "no joint state: '%.60s'%s", line,
                   strcmp(line, "header:") == 0 ? "; use ros2 topic echo --csv" : "");
    return MUKCA_LINE_FAULT;
}
