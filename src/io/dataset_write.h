/* A dataset as a session file or a pose log. */
#ifndef MUKCA_IO_DATASET_WRITE_H
#define MUKCA_IO_DATASET_WRITE_H

#include <stdio.h>

#include "mukca/dataset.h"

/* Between the columns of a new file: a comma where its name ends in .csv, else a tabulator. */
char mukca_dataset_separator(const char *path);

/* Write all rows in order under a header.  The dataset has times, and where it has sockets every
 * row has one; other optional columns are written where it has them and must then be whole.
 * Angles and positions get 12 decimals.  `comments` (may be NULL): whole lines, each becomes a `#`
 * line.  The caller checks the stream. */
void mukca_dataset_write(FILE *stream, const mukca_dataset *data, const mukca_chain *chain,
                         char separator, const char *comments);

#endif
