/* A dataset as a session file or a pose log. */
#ifndef MUKCA_IO_DATASET_WRITE_H
#define MUKCA_IO_DATASET_WRITE_H

#include <stdio.h>

#include "model/dataset.h"

/* Separator of a new file: a comma if its name ends in .csv, else a tab. */
char mukca_dataset_separator(const char *path);

/* Write all samples in order under a header.  The dataset must have times; if it has sockets, every
 * sample must have one.  Other optional columns are written if present and must then be complete.
 * Angles and positions get 12 decimals.  `comments` (may be NULL): complete lines, each written as
 * a `#` line.  The caller checks the stream. */
void mukca_dataset_write(FILE *stream, const mukca_dataset *data, const mukca_chain *chain,
                         char separator, const char *comments);

#endif
