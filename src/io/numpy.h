/* Arrays of numpy (.npy) as text. */
#ifndef MUKCA_IO_NUMPY_H
#define MUKCA_IO_NUMPY_H

#include <stdbool.h>
#include <stdio.h>

#include "mukca/status.h"

/* Whether the stream starts with an array; nothing is consumed. */
bool mukca_numpy_is_array(FILE *stream);

/* Replace *stream, such an array, by the same numbers as CSV; further dimensions than the first
 * become columns.  `path` is for messages. */
mukca_status mukca_numpy_read(FILE **stream, const char *path, mukca_error *error);

#endif
