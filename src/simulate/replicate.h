/* Replicates of a recording: the postures, placements and times of an existing one, with a known
 * arm and new noise (parametric bootstrap: Efron and Tibshirani, An Introduction to the Bootstrap,
 * 1993, section 6.5). */
#ifndef MUKCA_SIMULATE_REPLICATE_H
#define MUKCA_SIMULATE_REPLICATE_H

#include "simulate/simulate.h"

/* A socket that moved during its samples. */
typedef struct {
    int socket, row, file; /* data row of its file; 0: creep from the first to the last sample */
    double shift[3];       /* m, base frame */
} mukca_replicate_motion;

typedef struct {
    const mukca_true_arm *arm;
    const mukca_dataset *data; /* the existing recording */
    const int *posture;        /* [n_rows] first row of each row's posture */
    const double *move;  /* [n_rows][n_joints] angles minus those of the posture before, rad or m */
    mukca_frame tracker; /* pose logs: T_measured_base */
    double noise, rotation; /* sigma per axis, m; of orientations, rad */
    /* correlation of successive samples of a socket or log; share of the variance that all readings
     * of a posture have in common; one of them is 0 */
    double correlation, shared;
    const mukca_replicate_motion *motions;
    int n_motions;
} mukca_replicate_task;

/* out := a replicate.  Sockets: the angles change by the noise of the ball's seat, commands and
 * other readings with them; the sockets of a pair have their known distance.  Pose logs: the
 * measured poses change.  Free with mukca_dataset_free.  Errors: MUKCA_MEMORY. */
mukca_status mukca_simulate_replicate(mukca_dataset *out, const mukca_replicate_task *task,
                                      uint64_t seed, mukca_error *error);

#endif
