/* Columns and subsets of a dataset, commanded angles, states of the joints, postures. */
#ifndef MUKCA_MODEL_DATASET_SUBSET_H
#define MUKCA_MODEL_DATASET_SUBSET_H

#include "base/pool.h"
#include "math/random.h"
#include "model/dataset.h"
#include "mukca/row_state.h"

/* A row of MUKCA_COLUMN_LIST. */
typedef struct {
    int width;
    char of;
    int decimals;
    const char *name[4];
} mukca_column;

extern const mukca_column mukca_column_table[MUKCA_COLUMNS];

/* Numbers of a column per sample. */
static inline int mukca_column_width(int column, int n_joints)
{
    return mukca_column_table[column].width ? mukca_column_table[column].width : n_joints;
}

/* Copy of the samples with nonzero keep[row]; sockets, placements and distances are copied
 * unchanged, and their indices stay valid.  Errors: MUKCA_MEMORY. */
mukca_status mukca_dataset_subset(mukca_dataset *out, const mukca_dataset *data,
                                  const unsigned char *keep, mukca_error *error);

/* The same in place. */
mukca_status mukca_dataset_reduce(mukca_dataset *data, const unsigned char *keep,
                                  mukca_error *error);

/* Replace q by the commanded angles where a sample has some; without any, q are taken as commands.
 * The angles read are kept in `reading`.  Errors: MUKCA_MEMORY. */
mukca_status mukca_dataset_take_commands(mukca_dataset *data, mukca_error *error);

/* Joint state of a sample (mukca/row_state.h).  Call it for all samples in order, from 0; each file
 * is a separate recording.  The result points into `rows` and is valid until the next call. */
const mukca_joint_state *mukca_dataset_state(mukca_row_state *rows, const mukca_dataset *data,
                                             int row);

/* ---- a representative part of a long recording ---- */

/* Copy of at most some `most` samples: an equal share for each placement and for the measured
 * poses, or all of its samples if fewer; of a longer placement every k-th sample of each socket,
 * which preserves the proportions of its sockets.  Errors: MUKCA_MEMORY. */
mukca_status mukca_part_take(mukca_dataset *part, const mukca_dataset *data, int most,
                             mukca_error *error);

/* ---- condensing of a recording with too many rows for a diagnosis ---- */

/* Largest number of samples of a diagnosis, or of a verdict on a calibration: some 400 MB and ten
 * seconds.  It determines the noise and mean errors to 1 %, and detects amplitudes of a tenth of
 * the noise. */
enum { MUKCA_MOST_SAMPLES = 5000 };

typedef struct {
    int rows, postures; /* recorded rows; postures with standstill among them */
    int samples;        /* remaining samples */
} mukca_condensed;

/* If the data have more than `most` rows, successive rows of one posture are replaced by their
 * mean; of more than `most` postures, evenly spaced blocks of successive ones are kept.  Each
 * sample has the row number of its first row.  Errors: MUKCA_MEMORY. */
mukca_status mukca_condense(mukca_condensed *how, mukca_dataset *data, int most,
                            mukca_error *error);

/* ---- postures: rows with the same joint angles, wherever they stand (postures.c) ---- */

/* posture[n_rows] := the first row of each row's posture.  Returns the number of rows that repeat
 * one.  Scratch comes from `pool`; check pool->failed. */
int mukca_postures_find(int *posture, mukca_pool *pool, const mukca_dataset *data);

/* move[n_rows][n_joints] := mean angles q[n_rows][n_joints] of a row's posture minus those of the
 * posture before it: readings of one posture are no moves.  repeat[n_rows] := readings since the
 * arm arrived.  Both start at 0 in each file. */
void mukca_postures_move(double *move, int *repeat, mukca_pool *pool, const int *posture,
                         const mukca_dataset *data, const double *q);

/* ---- sockets (postures.c) ---- */

/* Index of the socket with this label in the placement of this name; -1: none. */
int mukca_dataset_find_socket(const mukca_dataset *data, const char *placement, const char *label);

/* Standard deviation of the distance between two sockets, m: the tolerance of a printed or milled
 * artefact of that size. */
#define MUKCA_DISTANCE_SIGMA 1e-4

static inline double mukca_distance_sigma(const mukca_distance *d)
{
    return d->sigma > 0 ? d->sigma : MUKCA_DISTANCE_SIGMA;
}

/* Set the artefact of the last distance: that of an earlier one between sockets of the same labels,
 * else a new one. */
void mukca_dataset_number_distance(mukca_dataset *data);

/* Artefacts of the distances are below this. */
int mukca_dataset_artefacts(const mukca_dataset *data);

/* Mean of the predicted tips of a socket's samples but `without` (-1: of all), m; returns their
 * number. */
int mukca_socket_mean(double mean[3], const mukca_geometry *geometry, const mukca_dataset *data,
                      int socket, int without);

/* Draw a posture q[n_joints] within the joint limits; a joint without limits turns once, or travels
 * 1 m. */
void mukca_posture_draw(double *q, const mukca_chain *chain, mukca_random *random);

#endif
