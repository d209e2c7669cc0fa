/* Condensing of recordings with too many rows for a diagnosis. */
#ifndef MUKCA_MODEL_CONDENSE_H
#define MUKCA_MODEL_CONDENSE_H

#include "model/dataset.h"

/* Largest number of samples of a diagnosis: some 400 MB and ten seconds.  It determines the noise
 * to 1 % and detects amplitudes of a tenth of the noise. */
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

#endif
