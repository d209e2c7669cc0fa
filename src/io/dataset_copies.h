/* Samples that repeat others to the last digit: a file given twice, a copy of it, rows pasted
 * again. */
#ifndef MUKCA_IO_DATASET_COPIES_H
#define MUKCA_IO_DATASET_COPIES_H

#include "base/note.h"
#include "mukca/dataset.h"

/* Drop the rows of `data` that repeat a row of `of`, or an earlier one of `data` where `of` is
 * NULL, and the sockets and placements that have none left; one note for each file.  A row repeats
 * another one where all joint angles and the label are equal, and nothing else that both have
 * (time, measured pose, effort and so on) differs; names of files and placements do not count. With
 * `of` NULL, a socket that would keep one row keeps all.
 * Returns MUKCA_OK or MUKCA_MEMORY. */
mukca_status mukca_dataset_drop_copies(mukca_dataset *data, const mukca_dataset *of,
                                       mukca_note_fn *note, void *context, mukca_error *error);

/* Keep the rows whose keep[row] is not 0, and the sockets and placements that have some.  Errors:
 * MUKCA_MEMORY. */
mukca_status mukca_dataset_keep(mukca_dataset *data, const unsigned char *keep, mukca_error *error);

#endif
