/* Duplicate samples, equal to the last digit: a file given twice, its copy, rows pasted again. */
#ifndef MUKCA_IO_DATASET_COPIES_H
#define MUKCA_IO_DATASET_COPIES_H

#include "base/note.h"
#include "model/dataset.h"

/* Remove the samples of `data` that repeat a sample of `of`, or if `of` is NULL an earlier sample
 * of `data`; then sockets and placements without samples.  One note per file.  Samples are
 * duplicates if all joint angles and the label are equal and all values that both have (time,
 * measured pose, effort and so on) agree; names of files and placements are not compared.  With
 * `of` NULL, a socket that would keep one sample keeps all.  Returns MUKCA_OK or MUKCA_MEMORY. */
mukca_status mukca_dataset_drop_copies(mukca_dataset *data, const mukca_dataset *of,
                                       mukca_note_fn *note, void *context, mukca_error *error);

/* Keep the samples with keep[i] != 0, and the sockets and placements that have some.  Errors:
 * MUKCA_MEMORY. */
mukca_status mukca_dataset_keep(mukca_dataset *data, const unsigned char *keep, mukca_error *error);

#endif
