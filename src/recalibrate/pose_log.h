/* Logs of joint angles with measured tip poses: read row by row, in any number of passes. */
#ifndef MUKCA_RECALIBRATE_POSE_LOG_H
#define MUKCA_RECALIBRATE_POSE_LOG_H

#include <stdbool.h>

#include "model/dataset.h"
#include "mukca/chain.h"

/* One row; values not recorded are NaN. */
typedef struct {
    double q[MUKCA_MAX_JOINTS];        /* rad or m */
    double velocity[MUKCA_MAX_JOINTS]; /* of q, per second, or per row without times */
    double position[3];                /* m */
    double quaternion[4];              /* w first; any length except 0 */
    double time;                       /* s */
    int file;                          /* consecutive rows of a file are in recording order */
} mukca_pose_row;

/* A log; its memory is independent of its length. */
typedef struct {
    /* The next row; at the end *more is false and there is no row. */
    mukca_status (*next)(void *context, mukca_pose_row *row, bool *more, mukca_error *error);
    mukca_status (*rewind)(void *context, mukca_error *error);
    void *context;
} mukca_pose_log;

/* The samples of a dataset that have a position, as a log.  `cursor` is the log's state and must
 * outlive it. */
typedef struct {
    const mukca_dataset *data;
    int at;
} mukca_pose_cursor;
void mukca_pose_log_from_dataset(mukca_pose_log *log, mukca_pose_cursor *cursor,
                                 const mukca_dataset *data);

/* Reader of several logs as one, with velocities: recorded, else by differences between neighbours
 * in time (in rows without times); 0 if neighbours are more than 0.2 rad or m apart.  Initialise
 * the three inputs, the rest zeroed. */
typedef struct {
    const mukca_pose_log *logs;
    int n_logs, n_joints;
    const mukca_pose_row *now; /* NULL after the last row */
    bool started;
    int log;               /* index of the log being read */
    mukca_pose_row row[3]; /* ring of the preceding, present and following row, from row[first] */
    int state[3], first;   /* of each row: 0 empty, else 1 + log */
} mukca_pose_reader;

/* Advance to the next row.  Errors: those of the logs. */
mukca_status mukca_pose_reader_next(mukca_pose_reader *reader, mukca_error *error);

#endif
