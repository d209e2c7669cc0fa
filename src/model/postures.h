/* Postures: rows of a recording with the same joint angles, wherever they stand in it. */
#ifndef MUKCA_MODEL_POSTURES_H
#define MUKCA_MODEL_POSTURES_H

#include "base/pool.h"
#include "model/dataset.h"

/* posture[n_rows] := the first row of each row's posture.  Returns the number of rows that repeat
 * one.  Scratch comes from `pool`; check pool->failed. */
int mukca_postures_find(int *posture, mukca_pool *pool, const mukca_dataset *data);

/* move[n_rows][n_joints] := mean angles q[n_rows][n_joints] of a row's posture minus those of the
 * posture before it: readings of one posture are no moves.  Starts at 0 in each file. */
void mukca_postures_move(double *move, mukca_pool *pool, const int *posture,
                         const mukca_dataset *data, const double *q);

#endif
