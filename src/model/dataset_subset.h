/* Subsets of a dataset, commanded angles, states of the joints. */
#ifndef MUKCA_MODEL_DATASET_SUBSET_H
#define MUKCA_MODEL_DATASET_SUBSET_H

#include "model/dataset.h"
#include "mukca/row_state.h"

/* Copy of the samples with nonzero keep[row]; sockets, placements and distances are copied
 * unchanged, and their indices stay valid.  Errors: MUKCA_MEMORY. */
mukca_status mukca_dataset_subset(mukca_dataset *out, const mukca_dataset *data,
                                  const unsigned char *keep, mukca_error *error);

/* Replace q by the commanded angles where a sample has some; without any, q are taken as commands.
 * The angles read are kept in `reading`.  Errors: MUKCA_MEMORY. */
mukca_status mukca_dataset_take_commands(mukca_dataset *data, mukca_error *error);

/* Joint state of a sample (mukca/row_state.h).  Call it for all samples in order, from 0; each file
 * is a separate recording.  The result points into `rows` and is valid until the next call. */
const mukca_joint_state *mukca_dataset_state(mukca_row_state *rows, const mukca_dataset *data,
                                             int row);

#endif
