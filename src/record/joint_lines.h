/* Joint states as lines of text: CSV with a header, JSON lines, `ros2 topic echo --csv`. */
#ifndef MUKCA_RECORD_JOINT_LINES_H
#define MUKCA_RECORD_JOINT_LINES_H

#include "lcm/decode.h"

enum {
    MUKCA_JOINT_LINES_SIZE = 1 << 16, /* bytes of a line; 64 joints take 6 kB */
    MUKCA_JOINT_LINES_CELLS = 4 + 4 * MUKCA_LCM_MAX_JOINTS
};

/* What a line is. */
typedef enum {
    MUKCA_LINE_NONE, /* a header, a comment, blank */
    MUKCA_LINE_JOINTS,
    MUKCA_LINE_TRIGGER, /* of JSON: {"trigger": 1, "placement": "front", "socket": "0"} */
    MUKCA_LINE_FAULT
} mukca_line_kind;

/* Where a column or a JSON member goes. */
typedef struct {
    int role; /* mukca_lcm_role; -1: ignored */
    int joint;
    double unit; /* us of a time */
} mukca_line_column;

/* A descriptor from which lines come, and the lines that it has brought. */
typedef struct {
    int fd;
    bool ended;
    bool file;          /* a regular file: lines do not come when they were made */
    const char *format; /* of the last line with joints: "CSV", "JSON lines", "ros2 topic echo" */
    int number;         /* of the line at hand, 1-based */
    size_t start, used; /* of what is in `buffer` */
    bool overlong;      /* the rest of the line is skipped */
    char buffer[MUKCA_JOINT_LINES_SIZE];
    /* the line at hand */
    char text[2 * MUKCA_JOINT_LINES_SIZE];
    char *cell[MUKCA_JOINT_LINES_CELLS];
    char placement[MUKCA_NAME_SIZE], socket[MUKCA_NAME_SIZE]; /* of a trigger, or "" */
    int64_t id;
    /* the header of CSV */
    int n_columns, n_joints;
    char delimiter;
    char header[MUKCA_JOINT_LINES_SIZE];
    mukca_line_column column[MUKCA_JOINT_LINES_CELLS];
    const char *joint[MUKCA_LCM_MAX_JOINTS]; /* names, into `header` or `text` */
} mukca_joint_lines;

void mukca_joint_lines_open(mukca_joint_lines *lines, int fd);

/* Take in what can be read without waiting long (call it when `fd` is readable); sets `ended`. */
void mukca_joint_lines_fill(mukca_joint_lines *lines);

/* The next whole line in the buffer (the last one also without its end), NULL: none. It stays the
 * next one until it is taken. */
const char *mukca_joint_lines_peek(mukca_joint_lines *lines);
void mukca_joint_lines_take(mukca_joint_lines *lines);

/* Parse a line of any content, without its end.  JOINTS: `joints` points into `lines` until the
 * next call; numbers that are missing or `nan` are NaN, a quantity without any finite number is not
 * there.  FAULT: `error` says what is wrong. */
mukca_line_kind mukca_joint_lines_parse(mukca_lcm_joints *joints, mukca_joint_lines *lines,
                                        const char *line, mukca_error *error);

/* The same for a line that is no JSON (joint_lines.c). */
mukca_line_kind mukca_joint_lines_parse_cells(mukca_lcm_joints *joints, mukca_joint_lines *lines,
                                              const char *line, mukca_error *error);

/* What a column or member of that name is: "time_s", "joint_1", "joint_1.effort"; new joints are
 * added to lines->joint.  False: too many joints.  `name` is cut at its suffix. */
bool mukca_joint_lines_classify(mukca_line_column *column, mukca_joint_lines *lines, char *name);

#endif
