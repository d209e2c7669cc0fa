/* Joint states as lines of text: CSV with a header, JSON lines, `ros2 topic echo --csv`. */
#ifndef MUKCA_RECORD_JOINT_LINES_H
#define MUKCA_RECORD_JOINT_LINES_H

#include "base/cells.h"
#include "io/runs.h"
#include "lcm/message.h"
#include "lcm/type.h"

enum {
    MUKCA_JOINT_LINES_SIZE = 1 << 16, /* bytes per line; 64 joints need 6 kB */
    MUKCA_JOINT_LINES_CELLS = 4 + 4 * MUKCA_LCM_MAX_JOINTS
};

/* Kinds of lines. */
typedef enum {
    MUKCA_LINE_NONE, /* a header, a comment or a blank line */
    MUKCA_LINE_JOINTS,
    MUKCA_LINE_TRIGGER, /* JSON: {"trigger": 1, "placement": "front", "socket": "0"} */
    MUKCA_LINE_FAULT
} mukca_line_kind;

/* A descriptor, its buffer and the current line. */
typedef struct {
    int fd;
    bool ended;
    bool file;          /* a regular file: the time of reading is not the time of recording */
    const char *format; /* of the last line with joints: "CSV", "JSON lines" or "ros2 topic echo" */
    int number;         /* of lines taken */
    int64_t arrived;    /* us, when the last bytes were read */
    size_t start, used; /* first and past-the-end index of unread bytes in `buffer` */
    bool overlong;      /* the beginning of the line was discarded */
    char buffer[MUKCA_JOINT_LINES_SIZE];
    /* the current line */
    char text[MUKCA_JOINT_LINES_SIZE];
    char *cell[MUKCA_JOINT_LINES_CELLS];
    mukca_message_trigger trigger; /* its texts are in `names`, or "" */
    bool timed;                    /* the joint state has a time, of any sign */
    size_t named;                  /* bytes used of: */
    char names[MUKCA_JOINT_LINES_SIZE];
    /* the CSV header */
    int n_columns;
    char delimiter;
    char header[MUKCA_JOINT_LINES_SIZE];
    char *column[MUKCA_JOINT_LINES_CELLS];    /* names */
    mukca_unit unit[MUKCA_JOINT_LINES_CELLS]; /* stated in the header */
} mukca_joint_lines;

void mukca_joint_lines_open(mukca_joint_lines *lines, int fd);

/* Read the available bytes (call this when `fd` is readable); sets `ended` at the end. */
void mukca_joint_lines_fill(mukca_joint_lines *lines);

/* The next complete line in the buffer (the last line may lack its end); NULL: none.  It remains
 * the next line until mukca_joint_lines_take. */
const char *mukca_joint_lines_peek(mukca_joint_lines *lines);
void mukca_joint_lines_take(mukca_joint_lines *lines);

/* Parse a line of any content, without its end.  JOINTS: `joints` points into `lines` until the
 * next call; missing numbers and `nan` are NaN, and a quantity without a finite number is absent.
 * FAULT: `error` has the reason. */
mukca_line_kind mukca_joint_lines_parse(mukca_lcm_joints *joints, mukca_joint_lines *lines,
                                        const char *line, mukca_error *error);

/* Read a run of a moving arm from a log of lcm-logger, from these lines, or else from a table by
 * mukca_run_read (run_states.c).  Errors: MUKCA_INPUT, MUKCA_MEMORY. */
mukca_status mukca_run_load(mukca_run *run, mukca_pool *pool, const char *path,
                            const mukca_chain *chain, const mukca_run_options *options,
                            mukca_error *error);

#endif
