/* Filtered signals of the runs on uniform grids, cut at gaps. */
#ifndef MUKCA_MOTION_SIGNALS_H
#define MUKCA_MOTION_SIGNALS_H

#include "base/pool.h"
#include "motion/motion.h"

/* Cutoff of the torques and of all columns, Hz: above any motion of an arm, below its structural
 * resonances; angles are filtered at MUKCA_ANGLE_CUTOFF times it before they are differentiated. */
#define MUKCA_MOTION_CUTOFF 8.0
#define MUKCA_ANGLE_CUTOFF 2.5
/* Slower joints stand still, rad/s. */
#define MUKCA_LEAST_MOTION 0.02

enum { MUKCA_PLAYS = 3 }; /* widths of the play operator */

/* Successive samples without a gap. */
typedef struct {
    int n;
    mukca_run_role role;
    double start;         /* s, since the first run began */
    double *q, *dq, *ddq; /* [n][n_joints] rad, rad/s, rad/s^2 */
    double *torque;       /* [n][n_joints] N m, measured */
    double *play;         /* [n][n_joints][MUKCA_PLAYS] -1 to 1 */
} mukca_stretch;

typedef struct {
    int n, n_joints;
    double dt, end; /* s: step of all grids, end of the last one */
    mukca_stretch *stretch;
    double range[MUKCA_MAX_JOINTS]; /* largest deviation of the torque from its mean */
    double low[MUKCA_MAX_JOINTS], high[MUKCA_MAX_JOINTS]; /* of the angles */
    double fastest[MUKCA_MAX_JOINTS];                     /* rad/s */
    double acceleration[MUKCA_MAX_JOINTS];                /* rad/s^2, rms */
    bool forwards[MUKCA_MAX_JOINTS], backwards[MUKCA_MAX_JOINTS];
} mukca_signals;

/* Memory comes from `pool`.  Errors: MUKCA_UNIDENTIFIABLE (no motion), MUKCA_MEMORY. */
mukca_status mukca_signals_make(mukca_signals *signals, mukca_pool *pool,
                                const mukca_motion_input *input, mukca_error *error);

#endif
