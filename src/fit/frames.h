/* Frames of measured poses as elements of the chain. */
#ifndef MUKCA_FIT_FRAMES_H
#define MUKCA_FIT_FRAMES_H

#include "fit/parameters.h"
#include "mukca/dataset.h"

/* Copy of `chain` with a fixed element in front (the tracker's frame to the arm's base) and, where
 * the chain does not end in a fixed joint, one behind (the target on the flange).
 * Errors: MUKCA_INPUT (too many elements). */
mukca_status mukca_chain_with_frames(mukca_chain *out, const mukca_chain *chain, bool base,
                                     bool tool, mukca_error *error);

/* theta[6 * n_elements] to start from: nominal, with the added frames aligned to the measured
 * poses (of several targets: of the first). Errors: MUKCA_MEMORY. */
mukca_status mukca_frames_start(double *theta, const mukca_chain *with_frames,
                                const mukca_dataset *data, bool base, bool tool,
                                mukca_error *error);

#endif
