/* Joint states as lines of text: buffering, CSV, JSON, and the output of `ros2 topic echo --csv`.
 */
#include "record/joint_lines.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/cells.h"
#include "base/clock.h"
#include "base/number.h"
#include "io/table.h"

void mukca_joint_lines_open(mukca_joint_lines *lines, int fd)
{
    struct stat info;
    memset(lines, 0, sizeof *lines);
    lines->fd = fd;
    lines->file = fstat(fd, &info) == 0 && S_ISREG(info.st_mode);
    lines->format = "lines";
}

/* mukca_fail, for a line that is no joint state or trigger. */
#define fault(error, ...) (mukca_fail(error, MUKCA_INPUT, __VA_ARGS__), MUKCA_LINE_FAULT)

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

/* A line longer than the buffer is discarded up to its end, which is returned. */
const char *mukca_joint_lines_peek(mukca_joint_lines *l)
{
    char *line = l->buffer + l->start;
    char *end = memchr(line, '\n', l->used - l->start);
    if (!end && l->ended && (l->start < l->used || l->overlong)) end = l->buffer + l->used;
    if (!end && l->used - l->start == sizeof l->buffer - 1) {
        l->start = l->used = 0;
        l->overlong = true;
    }
    if (!end) return NULL;
    *end = '\0';
    return line;
}

void mukca_joint_lines_take(mukca_joint_lines *l)
{
    l->start += strlen(l->buffer + l->start) + 1;
    if (l->start > l->used) l->start = l->used; /* the last line may lack its end */
    l->number++;
    l->overlong = false;
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

/* No numbers and names. */
static void clear(mukca_lcm_joints *joints, mukca_joint_lines *l)
{
    *joints = (mukca_lcm_joints){.time = 0};
    l->timed = false;
    for (int r = 0; r < MUKCA_LCM_ROLES; r++)
        for (int j = 0; j < MUKCA_LCM_MAX_JOINTS; j++) joints->value[r][j] = (double)NAN;
    l->named = 0;
}

static void store(mukca_lcm_joints *joints, int role, int joint, double value)
{
    joints->value[role][joint] = value;
    joints->has[role] |= isfinite(value);
}

/* Append a joint; all names of a line fit. */
static void add_joint(mukca_lcm_joints *joints, mukca_joint_lines *l, const char *name,
                      size_t length)
{
    char *copy = l->names + l->named;
    memcpy(copy, name, length);
    copy[length] = '\0';
    l->named += length + 1;
    joints->name[joints->n++] = copy;
    joints->has[MUKCA_LCM_ROLE_NAME] = true;
}

/* us per unit of the time in a column or member; 0: no time. */
static double time_unit(const char *name)
{
    static const char *const seconds[] = {"time_s", "time", "timestamp"};
    for (int i = 0; i < 3; i++)
        if (strcmp(name, seconds[i]) == 0) return 1e6;
    return strcmp(name, "utime") == 0;
}

/* Members of a message, and endings of a column's name such as joint_1.effort, by role. */
static const char *const role_names[] = {[MUKCA_LCM_ROLE_POSITION] = "position",
                                         [MUKCA_LCM_ROLE_VELOCITY] = "velocity",
                                         [MUKCA_LCM_ROLE_EFFORT] = "effort",
                                         [MUKCA_LCM_ROLE_COMMAND] = "command"};

/* Store the number of a column or member such as time_s, joint_1, joint_1.effort.  False: too many
 * joints. */
static bool put(mukca_lcm_joints *joints, mukca_joint_lines *l, const char *name, double value)
{
    const double time = time_unit(name) * value;
    const char *dot = strrchr(name, '.');
    size_t length = strlen(name);
    int role = MUKCA_LCM_ROLE_POSITION, joint = 0;
    if (time_unit(name) > 0) {
        l->timed = fabs(time) < 9e18;
        joints->time = l->timed ? (int64_t)llround(time) : 0;
        return true;
    }
    if (mukca_columns_reserved(name) || strcmp(name, "target") == 0) return true;
    for (int r = MUKCA_LCM_ROLE_VELOCITY; dot && r <= MUKCA_LCM_ROLE_COMMAND; r++)
        if (strcmp(dot + 1, role_names[r]) == 0) role = r;
    if (dot && strcmp(dot, MUKCA_COLUMNS_SPREAD) == 0) role = -1;
    if (role != MUKCA_LCM_ROLE_POSITION) length = (size_t)(dot - name);
    while (joint < joints->n &&
           (strncmp(joints->name[joint], name, length) != 0 || joints->name[joint][length] != '\0'))
        joint++;
    if (joint == MUKCA_LCM_MAX_JOINTS) return false;
    if (joint == joints->n) add_joint(joints, l, name, length);
    if (role >= 0) store(joints, role, joint, value);
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

static mukca_line_kind read_row(mukca_lcm_joints *joints, mukca_joint_lines *l, int n,
                                mukca_error *error)
{
    if (n != l->n_columns) return fault(error, "%d columns, but %d in the header", n, l->n_columns);
    clear(joints, l);
    bool good = true;
    for (int i = 0; i < n; i++) {
        double value;
        (void)read_cell(&value, l->cell[i]); /* the recorder checks the arm's joints */
        good = good && put(joints, l, l->column[i],
                           l->unit[i].factor > 0 ? l->unit[i].factor * value : value);
    }
    l->format = "CSV";
    if (good && joints->n) return MUKCA_LINE_JOINTS;
    return fault(error, "no joint, or more than %d", (int)MUKCA_LCM_MAX_JOINTS);
}

/* ---- ros2 topic echo --csv ---- */

/* Parse sec, nanosec, frame, then names, positions, velocities and efforts of
 * sensor_msgs/JointState; an empty array is one empty cell (message_to_csv of rosidl_runtime_py).
 * False: not such a line. */
static bool read_ros(mukca_lcm_joints *joints, mukca_joint_lines *l, int n)
{
    enum { FIRST = 3 };
    long long time[2]; /* s, ns */
    double value;
    if (n < FIRST + 4) return false;
    for (int i = 0; i < 2; i++) {
        const size_t digits = strspn(l->cell[i], "0123456789");
        if (!digits || digits > 15 || l->cell[i][digits]) return false;
        time[i] = strtoll(l->cell[i], NULL, 10);
    }
    int names = 0, at = FIRST;
    while (at < n && !read_cell(&value, l->cell[at])) at++, names++;
    if (!names || names > MUKCA_LCM_MAX_JOINTS || time[0] > INT32_MAX) return false;
    clear(joints, l);
    joints->time = 1000000 * time[0] + time[1] / 1000;
    l->timed = joints->time > 0; /* a header that is not stamped is 0 */
    for (int j = 0; j < names; j++)
        add_joint(joints, l, l->cell[FIRST + j], strlen(l->cell[FIRST + j]));
    for (int r = MUKCA_LCM_ROLE_POSITION; r <= MUKCA_LCM_ROLE_EFFORT; r++) {
        /* one joint: an empty cell is an empty array or an unknown value; both mean the same */
        const bool empty = at < n && !*l->cell[at];
        const int count = empty ? 1 : names;
        if (at + count > n) return false;
        for (int j = 0; j < count && !empty; j++) {
            if (!read_cell(&value, l->cell[at + j])) return false;
            store(joints, r, j, value);
        }
        at += count;
    }
    return at == n;
}

static mukca_line_kind parse_cells(mukca_lcm_joints *joints, mukca_joint_lines *l, const char *line,
                                   mukca_error *error)
{
    if (!*line || *line == '#') return MUKCA_LINE_NONE;
    memcpy(l->text, line, strlen(line) + 1);
    const char delimiter = mukca_cells_delimiter(line);
    const int n = mukca_cells_count(line, delimiter);
    if (n > MUKCA_JOINT_LINES_CELLS)
        return fault(error, "%d cells; at most %d are read", n, (int)MUKCA_JOINT_LINES_CELLS);
    mukca_cells_split(l->cell, n, l->text, delimiter);
    if (read_ros(joints, l, n)) {
        l->format = "ros2 topic echo";
        return MUKCA_LINE_JOINTS;
    }
    if (is_header(l->cell, n)) {
        memcpy(l->header, line, strlen(line) + 1);
        mukca_cells_split(l->column, n, l->header, delimiter);
        for (int i = 0; i < n; i++) l->unit[i] = mukca_unit_take(l->column[i]);
        l->delimiter = delimiter;
        l->n_columns = n;
        return MUKCA_LINE_NONE;
    }
    if (l->n_columns && delimiter == l->delimiter) return read_row(joints, l, n, error);
    double value;
    if (n > 1 && read_cell(&value, l->cell[n - 1]) && read_cell(&value, l->cell[0]))
        return fault(error,
                     "neither a row under a header of names nor a whole message of `ros2 topic "
                     "echo --csv`");
    return fault(error, "no joint state: '%.60s'%s", line,
                 strcmp(line, "header:") == 0 ? "; use ros2 topic echo --csv" : "");
}

/* ---- JSON: arrays as in sensor_msgs/JointState, or a member per joint ---- */

/* NaN if the value is not a number; an empty object is NaN, too. */
static double number(const json_t *value)
{
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

/* Time from header.stamp (sec, nanosec), us; 0: none. */
static int64_t read_stamp(const json_t *message)
{
    const json_t *stamp = json_object_get(json_object_get(message, "header"), "stamp");
    const int64_t whole = json_integer_value(json_object_get(stamp, "sec")),
                  nano = json_integer_value(json_object_get(stamp, "nanosec"));
    const bool valid = whole > 0 && whole < INT32_MAX && nano >= 0 && nano < 1000000000;
    return valid ? 1000000 * whole + nano / 1000 : 0;
}

/* {"name": [...], "position": [...], "velocity": [...], "effort": [...]} */
static bool read_arrays(mukca_lcm_joints *joints, mukca_joint_lines *l, const json_t *message)
{
    const json_t *names = json_object_get(message, "name");
    const size_t n = json_array_size(json_object_get(message, "position"));
    if (n < 1 || n > MUKCA_LCM_MAX_JOINTS) return false;
    for (int r = MUKCA_LCM_ROLE_POSITION; r <= MUKCA_LCM_ROLE_COMMAND; r++) {
        const json_t *array = json_object_get(message, role_names[r]);
        const size_t length = json_array_size(array);
        if (length != 0 && length != n) return false;
        for (size_t k = 0; k < length; k++)
            store(joints, r, (int)k, number(json_array_get(array, k)));
    }
    for (size_t k = 0; k < json_array_size(names); k++) {
        const char *name = json_string_value(json_array_get(names, k));
        if (!name || json_array_size(names) != n) return false;
        add_joint(joints, l, name, strlen(name));
    }
    joints->n = (int)n;
    return true;
}

/* Keep a label, a text or an integer, after the names of the line; both fit, as JSON is longer. */
static const char *keep_label(mukca_joint_lines *l, const json_t *value)
{
    char *label = l->names + l->named;
    const size_t room = sizeof l->names - l->named;
    const int n =
        json_is_integer(value)
            ? snprintf(label, room, "%lld", (long long)json_integer_value(value))
            : snprintf(label, room, "%s", json_is_string(value) ? json_string_value(value) : "");
    l->named += (size_t)n + 1;
    return label;
}

/* {"trigger": 1, "placement": "front", "socket": 0}; the labels are optional. */
static mukca_line_kind read_trigger(mukca_joint_lines *l, json_t *message, mukca_error *error)
{
    const char *key;
    json_t *value;
    json_object_foreach(message, key, value)
    {
        const bool label = strcmp(key, "placement") == 0 || strcmp(key, "socket") == 0;
        if (label ? json_is_string(value) || json_is_integer(value) || json_is_null(value)
                  : strcmp(key, "trigger") == 0 || time_unit(key) > 0)
            continue;
        return fault(error, "%.40s: %s", key,
                     label ? "a text or an integer is needed"
                           : "a trigger has the members trigger, placement and socket");
    }
    l->trigger =
        (mukca_message_trigger){.id = json_integer_value(json_object_get(message, "trigger")),
                                .placement = keep_label(l, json_object_get(message, "placement")),
                                .socket = keep_label(l, json_object_get(message, "socket"))};
    return MUKCA_LINE_TRIGGER;
}

/* A joint state: arrays, or one member per joint. */
static mukca_line_kind read_state(mukca_lcm_joints *joints, mukca_joint_lines *l, json_t *message,
                                  mukca_error *error)
{
    const bool arrays = json_object_get(message, "position") != NULL;
    const int64_t stamp = read_stamp(message);
    bool good = true;
    const char *key;
    json_t *value;
    json_object_foreach(message, key, value)
    {
        const bool empty = json_is_null(value) || (json_is_array(value) && !json_array_size(value));
        if ((!json_is_number(value) && !empty) || (arrays && !time_unit(key))) continue;
        good = good && put(joints, l, key, number(value));
    }
    if (stamp) joints->time = stamp, l->timed = true;
    l->format = "JSON lines";
    if (good && (arrays ? read_arrays(joints, l, message) : joints->has[MUKCA_LCM_ROLE_POSITION]))
        return MUKCA_LINE_JOINTS;
    return fault(error,
                 "no joint state: \"position\" must be 1 to %d numbers, and name, velocity, effort "
                 "as many or none; or one member per joint",
                 (int)MUKCA_LCM_MAX_JOINTS);
}

static mukca_line_kind parse_object(mukca_lcm_joints *joints, mukca_joint_lines *l,
                                    const char *line, mukca_error *error)
{
    json_error_t wrong;
    memcpy(l->text, line, strlen(line) + 1);
    bool quoted = false;
    for (char *at = l->text; *at; at++) { /* Python writes NaN, JSON lacks it */
        quoted ^= *at == '"' && (at == l->text || at[-1] != '\\');
        if (!quoted && strncmp(at, "NaN", 3) == 0) memcpy(at, "[] ", 3);
    }
    json_t *root = json_loads(l->text, JSON_REJECT_DUPLICATES, &wrong);
    if (!root) return fault(error, "column %d: %.100s", wrong.column, wrong.text);
    json_t *message = json_object_get(root, "msg"); /* as a ROS bridge sends it */
    if (!json_is_object(message)) message = root;
    clear(joints, l);
    const mukca_line_kind kind = json_object_get(message, "trigger")
                                     ? read_trigger(l, message, error)
                                     : read_state(joints, l, message, error);
    json_decref(root);
    return kind;
}

mukca_line_kind mukca_joint_lines_parse(mukca_lcm_joints *joints, mukca_joint_lines *l,
                                        const char *line, mukca_error *error)
{
    if (l->overlong) return fault(error, "a line of more than %d bytes", MUKCA_JOINT_LINES_SIZE);
    line += strspn(line, " \r");
    return *line == '{' ? parse_object(joints, l, line, error)
                        : parse_cells(joints, l, line, error);
}
