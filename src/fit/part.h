/* A representative part of a long recording. */
#ifndef MUKCA_FIT_PART_H
#define MUKCA_FIT_PART_H

#include "model/dataset.h"

/* Set keep[n_rows] to 1 for at most some `most` samples: an equal share of `most` for each
 * placement and for the measured poses, or all of its samples if fewer.  Of a longer placement
 * every k-th sample of each socket, which preserves the proportions of its sockets.  Returns the
 * number kept, -1: out of memory. */
int mukca_part_mark(unsigned char *keep, const mukca_dataset *data, int most);

/* Copy of the part.  Errors: MUKCA_MEMORY. */
mukca_status mukca_part_take(mukca_dataset *part, const mukca_dataset *data, int most,
                             mukca_error *error);

#endif
