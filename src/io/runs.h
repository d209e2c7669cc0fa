/* Runs of a moving arm from tables. */
#ifndef MUKCA_IO_RUNS_H
#define MUKCA_IO_RUNS_H

#include "io/rows.h"
#include "motion/motion.h"

typedef struct {
    mukca_rows_format format;
    bool current; /* efforts are motor currents: JOINT.effort, or of joint states */
    /* [n_joints] N m/A; N m/rad, effort = gain (command - angle) where no effort is; NaN: none */
    double gain[MUKCA_MAX_JOINTS], stiffness[MUKCA_MAX_JOINTS];
    mukca_notes notes;
} mukca_run_options;

/* Read a table of times, joint angles and efforts (or currents) into run->time, q and effort, whose
 * memory comes from `pool`, and run->current.  Rows without all numbers, and rows that repeat a
 * time, are dropped with a note.  Errors: MUKCA_INPUT, MUKCA_MEMORY. */
mukca_status mukca_run_read(mukca_run *run, mukca_pool *pool, const char *path,
                            const mukca_chain *chain, const mukca_run_options *options,
                            mukca_error *error);

/* Rows of a run as they are read.  Zeroed: none. */
typedef struct {
    double *sample; /* [n][1 + 3 n_joints] s, rad, rad/s (NaN: unknown), N m; to be freed */
    int n, incomplete, repeated;
    bool failed; /* no memory */
} mukca_run_rows;

/* Add a row, unless it is incomplete or repeats the last time.  Returns by how much the time has
 * fallen, s; 0: not. */
double mukca_run_rows_add(mukca_run_rows *rows, const double *row, int n_joints);

/* The run of these rows; run->name is set.  Notes what was left out, and velocities that are not
 * the derivative of the angles.  Errors: MUKCA_MEMORY, without a message. */
mukca_status mukca_run_rows_take(mukca_run *run, mukca_pool *pool, const mukca_run_rows *rows,
                                 const mukca_chain *chain, const mukca_run_options *options);

#endif
