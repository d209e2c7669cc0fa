/* Rows of joint angles with measured tip poses, read one after the other, as often as needed. */
#ifndef MUKCA_RECALIBRATE_POSE_LOG_H
#define MUKCA_RECALIBRATE_POSE_LOG_H

#include <stdbool.h>

#include "mukca/chain.h"
#include "mukca/dataset.h"

/* NaN where something was not recorded. */
typedef struct {
    double q[MUKCA_MAX_JOINTS];        /* rad or m */
    double velocity[MUKCA_MAX_JOINTS]; /* of q, per second, or per row where there is no time */
    double position[3];                /* m */
    double quaternion[4];              /* w first; any length but 0 */
    double time;                       /* s */
    int file;                          /* rows are in recording order within a file */
} mukca_pose_row;

/* A log: memory does not depend on its length. */
typedef struct {
    /* The next row; *more false (and no row) at the end. */
    mukca_status (*next)(void *context, mukca_pose_row *row, bool *more, mukca_error *error);
    mukca_status (*rewind)(void *context, mukca_error *error);
    void *context;
    double weight; /* of each row in a fit; 0: 1 */
} mukca_pose_log;

/* Rows of a dataset that have a position.  `cursor` is the log's place and must outlive it. */
typedef struct {
    const mukca_dataset *data;
    int at;
} mukca_pose_cursor;
void mukca_pose_log_from_dataset(mukca_pose_log *log, mukca_pose_cursor *cursor,
                                 const mukca_dataset *data);

/* Several logs read as one, each row with velocities: as recorded, else by differences to the
 * neighbours in time (in rows where there is no time); 0 where neighbours are further than 0.2 rad
 * or m apart.  Begin with the three inputs and zeros. */
typedef struct {
    const mukca_pose_log *logs;
    int n_logs, n_joints;
    const mukca_pose_row *now; /* NULL after the last row */
    double weight;             /* of its log */
    bool started;
    int log;               /* which one is being read */
    mukca_pose_row row[3]; /* before, now, after: in turn, from row[first] on */
    int state[3], first;   /* state of row: 0 empty, else 1 + log */
} mukca_pose_reader;

/* Move to the next row.  Errors: the logs' own. */
mukca_status mukca_pose_reader_next(mukca_pose_reader *reader, mukca_error *error);

#endif
