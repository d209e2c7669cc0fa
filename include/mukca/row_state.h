/* Joint state of a sample from the samples before it: one accumulator for files, streams and
 * datasets.
 *
 * Feed the samples of one recording in order; start again for each file.  A missing time continues
 * at MUKCA_SECONDS_PER_ROW from the last known one.  A joint without a command counts as commanded
 * to its reading: the sample shows no lag of that joint.
 */
#ifndef MUKCA_ROW_STATE_H
#define MUKCA_ROW_STATE_H

#include "mukca/effect.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Recorded values of one sample. */
typedef struct {
    const double *q;       /* [n_joints] encoder angles, rad or m */
    const double *command; /* [n_joints] or NULL; NaN: missing */
    double time;           /* s on any clock; NaN: missing */
    double payload_kg;     /* NaN: missing, taken as 0 */
    int placement;         /* index, -1: unknown */
    int number;            /* row in the file: skipped rows take time, too */
} mukca_row_reading;

/* `state` is that of the last sample and points into this structure: do not copy it. */
typedef struct {
    mukca_joint_state state; /* torque and moments stay NULL */
    int n_joints, rows;
    int number;    /* of the last row */
    double start;  /* time of the recording's start on its clock; NaN: unknown so far */
    double window; /* rad or m; 0: samples, see mukca_row_state_stream */
    double q[MUKCA_MAX_JOINTS], before[MUKCA_MAX_JOINTS];
    double move[MUKCA_MAX_JOINTS], command[MUKCA_MAX_JOINTS];
} mukca_row_state;

/* Begin a recording of samples: the move is the angles minus those of the previous sample (0 in the
 * first sample). */
void mukca_row_state_start(mukca_row_state *rows, int n_joints);

/* Begin a stream of joint states of a moving arm.  The move of a joint is then its travel since its
 * last reversal, at most 0.1 rad (or m): the play operator of Prandtl and Ishlinskii.  Unlike
 * differences of successive states it does not depend on their rate, and it keeps the direction of
 * approach during standstill. */
void mukca_row_state_stream(mukca_row_state *rows, int n_joints);

/* Add the next sample; returns its state, valid until the next call. */
const mukca_joint_state *mukca_row_state_next(mukca_row_state *rows,
                                              const mukca_row_reading *reading);

/* Replace the angles of the last sample by a trial posture of a search, or by the one sent. */
const mukca_joint_state *mukca_row_state_set(mukca_row_state *rows, const double *q);

#ifdef __cplusplus
}
#endif
#endif
