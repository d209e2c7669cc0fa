/* A part of a long recording that stands for all of it. */
#ifndef MUKCA_FIT_PART_H
#define MUKCA_FIT_PART_H

#include "mukca/dataset.h"

/* keep[n_rows] = 1 for some `most` samples or fewer: of each placement, and of the measured poses,
 * an equal share of `most`, or all; of a longer one every k-th sample of each socket, so that its
 * sockets keep their proportions.  Returns the number kept.  Errors: -1, out of memory. */
int mukca_part_mark(unsigned char *keep, const mukca_dataset *data, int most);

/* Copy of the part.  Errors: MUKCA_MEMORY. */
mukca_status mukca_part_take(mukca_dataset *part, const mukca_dataset *data, int most,
                             mukca_error *error);

#endif
