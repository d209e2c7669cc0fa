/* Recordings of several rows for each posture, or of more rows than a diagnosis can hold. */
#ifndef MUKCA_DIAGNOSE_CONDENSE_H
#define MUKCA_DIAGNOSE_CONDENSE_H

#include "mukca/dataset.h"

/* Samples that a diagnosis takes: some 400 MB and ten seconds.  The noise is then known to 1 %, and
 * amplitudes of a tenth of it are found. */
enum { MUKCA_MOST_SAMPLES = 5000 };

typedef struct {
    int rows, postures; /* recorded rows; postures in which the arm stood still for them */
    int samples;        /* that are left */
} mukca_condensed;

/* Where samples of sockets repeat postures, or the data have more than `most` rows, the rows of
 * each still posture become their mean; of more postures than `most`, blocks of successive ones are
 * kept, evenly spread.  Each sample keeps the row number of its first row.  Errors: MUKCA_MEMORY.
 */
mukca_status mukca_condense(mukca_condensed *how, mukca_dataset *data, int most,
                            mukca_error *error);

#endif
