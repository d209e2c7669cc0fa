/* Joint states as JSON lines: arrays as in sensor_msgs/JointState, or a member per joint. */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/utf8.h"
#include "record/joint_lines.h"

/* NaN if the value is not a number. */
static double number(const json_t *value)
{
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

/* Replace NaN, which Python writes but JSON lacks, by null.  `to` has room for twice the line. */
static void replace_nan(char *to, const char *from)
{
    bool text = false;
    for (; *from; from++) {
        if (text && *from == '\\' && from[1]) {
            *to++ = *from++;
        } else if (*from == '"') {
            text = !text;
        } else if (!text && strncmp(from, "NaN", 3) == 0) {
            memcpy(to, "null", 4);
            to += 4, from += 2;
            continue;
        }
        *to++ = *from;
    }
    *to = '\0';
}

/* Time from header.stamp (sec, nanosec; ROS 1: secs, nsecs) or a time member, us; 0: none. */
static int64_t read_time(const json_t *message)
{
    const json_t *stamp = json_object_get(json_object_get(message, "header"), "stamp");
    const json_t *seconds = json_object_get(stamp, "sec"),
                 *rest = json_object_get(stamp, "nanosec");
    if (!seconds) seconds = json_object_get(stamp, "secs"), rest = json_object_get(stamp, "nsecs");
    const int64_t whole = json_integer_value(seconds), nano = json_integer_value(rest);
    if (whole > 0 && whole < INT32_MAX && nano >= 0 && nano < 1000000000)
        return 1000000 * whole + nano / 1000;
    const json_t *us = json_object_get(message, "utime");
    if (us) return json_integer_value(us);
    const json_t *own = json_object_get(message, "time_s");
    if (!own) own = json_object_get(message, "time");
    const double s = number(own);
    return fabs(s) < 9e12 ? (int64_t)llround(1e6 * s) : 0;
}

/* Read the first `n` values of an array; a value that is not a number becomes NaN. */
static bool read_array(mukca_lcm_joints *joints, int role, const json_t *array, int n)
{
    if (json_array_size(array) == 0) return true;
    if (json_array_size(array) != (size_t)n) return false;
    for (int j = 0; j < n; j++) {
        const double value = number(json_array_get(array, (size_t)j));
        joints->value[role][j] = value;
        joints->has[role] |= isfinite(value);
    }
    return true;
}

/* {"name": [...], "position": [...], "velocity": [...], "effort": [...]} */
static bool read_arrays(mukca_lcm_joints *joints, mukca_joint_lines *l, const json_t *message)
{
    static const struct {
        const char *key;
        int role;
    } arrays[] = {{"position", MUKCA_LCM_ROLE_POSITION},
                  {"velocity", MUKCA_LCM_ROLE_VELOCITY},
                  {"effort", MUKCA_LCM_ROLE_EFFORT},
                  {"command", MUKCA_LCM_ROLE_COMMAND}};
    const json_t *names = json_object_get(message, "name");
    const size_t n = json_array_size(json_object_get(message, "position"));
    size_t used = 0;
    if (n < 1 || n > MUKCA_LCM_MAX_JOINTS) return false;
    joints->n = (int)n;
    for (int a = 0; a < 4; a++)
        if (!read_array(joints, arrays[a].role, json_object_get(message, arrays[a].key), (int)n))
            return false;
    if (json_array_size(names) == 0) return true;
    for (size_t j = 0; j < n; j++) {
        const char *name = json_string_value(json_array_get(names, j));
        if (!name || json_array_size(names) != n) return false;
        joints->name[j] =
            memcpy(l->text + used, name, strlen(name) + 1); /* fits: the names come from the line */
        used += strlen(name) + 1;
    }
    joints->has[MUKCA_LCM_ROLE_NAME] = true;
    return true;
}

/* {"time_s": 1.5, "joint_1": 0.1, "joint_1.effort": 3} */
static bool read_members(mukca_lcm_joints *joints, mukca_joint_lines *l, json_t *message)
{
    const char *key;
    json_t *value;
    size_t used = 0;
    l->n_joints = l->n_columns = 0;
    json_object_foreach(message, key, value)
    {
        mukca_line_column column;
        if (!json_is_number(value) && !json_is_null(value)) continue;
        char *name = memcpy(l->text + used, key, strlen(key) + 1);
        used += strlen(key) + 1;
        if (!mukca_joint_lines_classify(&column, l, name)) return false;
        if (column.role < 0 || column.role == MUKCA_LCM_ROLE_TIME) continue;
        joints->value[column.role][column.joint] = number(value);
        joints->has[column.role] |= json_is_number(value);
    }
    joints->n = l->n_joints;
    memcpy(joints->name, l->joint, sizeof joints->name);
    joints->has[MUKCA_LCM_ROLE_NAME] = true;
    return joints->has[MUKCA_LCM_ROLE_POSITION];
}

static void copy_label(char label[MUKCA_NAME_SIZE], const json_t *value)
{
    const char *text = json_string_value(value);
    snprintf(label, MUKCA_NAME_SIZE, "%s", text ? text : "");
    mukca_utf8_mend(label);
}

static mukca_line_kind parse_object(mukca_lcm_joints *joints, mukca_joint_lines *l,
                                    const char *line, mukca_error *error)
{
    json_error_t fault;
    mukca_line_kind kind = MUKCA_LINE_FAULT;
    replace_nan(l->text, line);
    json_t *root = json_loads(l->text, JSON_REJECT_DUPLICATES, &fault);
    if (!root) {
        mukca_fail(error, MUKCA_INPUT, "column %d: %.100s", fault.column, fault.text);
        return MUKCA_LINE_FAULT;
    }
    json_t *message = json_object_get(root, "msg"); /* as a ROS bridge sends it */
    if (!json_is_object(message)) message = root;
    const json_t *trigger = json_object_get(message, "trigger");
    mukca_joint_lines_clear(joints, MUKCA_LCM_MAX_JOINTS);
    joints->time = read_time(message);
    if (trigger) {
        l->id = json_integer_value(trigger);
        copy_label(l->placement, json_object_get(message, "placement"));
        copy_label(l->socket, json_object_get(message, "socket"));
        kind = MUKCA_LINE_TRIGGER;
    } else if (json_object_get(message, "position") ? read_arrays(joints, l, message)
                                                    : read_members(joints, l, message)) {
        kind = MUKCA_LINE_JOINTS;
        l->format = "JSON lines";
    } else {
        mukca_fail(
            error, MUKCA_INPUT,
            "no joint state: \"position\" must be 1 to %d numbers, and name, velocity, effort "
            "as many or none; or one member per joint",
            (int)MUKCA_LCM_MAX_JOINTS);
    }
    json_decref(root);
    return kind;
}

mukca_line_kind mukca_joint_lines_parse(mukca_lcm_joints *joints, mukca_joint_lines *l,
                                        const char *line, mukca_error *error)
{
    line += strspn(line, " \r");
    return *line == '{' ? parse_object(joints, l, line, error)
                        : mukca_joint_lines_parse_cells(joints, l, line, error);
}
