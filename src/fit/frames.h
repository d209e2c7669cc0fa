/* Frames of measured poses as elements of the chain. */
#ifndef MUKCA_FIT_FRAMES_H
#define MUKCA_FIT_FRAMES_H

#include "fit/parameters.h"
#include "model/dataset.h"

/* Copy of `chain` with a fixed element in front (from the tracker's frame to the arm's base) and,
 * if the chain does not end in a fixed joint, one at the end (target on the flange).  Errors:
 * MUKCA_INPUT (too many elements). */
mukca_status mukca_chain_with_frames(mukca_chain *out, const mukca_chain *chain, bool base,
                                     bool tool, mukca_error *error);

/* Initial theta[6 * n_elements]: nominal, with the added frames aligned to the measured poses (with
 * several targets, to those of the first).  Errors: MUKCA_MEMORY. */
mukca_status mukca_frames_start(double *theta, const mukca_chain *with_frames,
                                const mukca_dataset *data, bool base, bool tool,
                                mukca_error *error);

#endif
