/* Summaries of recordings as files: JSON (mukca.summary/1), one per line; files can be
 * concatenated. */
#ifndef MUKCA_IO_SUMMARY_H
#define MUKCA_IO_SUMMARY_H

#include <stdio.h>

#include "fleet/summary.h"

/* Write one line.  Errors: MUKCA_MEMORY. */
mukca_status mukca_summary_write(FILE *stream, const mukca_summary *summary, mukca_error *error);

/* Callback for one summary. */
typedef mukca_status mukca_summary_fn(void *context, const mukca_summary *summary,
                                      mukca_error *error);

/* Read all summaries of `path`.  Errors: MUKCA_INPUT (file and line), MUKCA_MEMORY, and those of
 * `take`. */
mukca_status mukca_summary_read(const char *path, mukca_summary_fn *take, void *context,
                                mukca_error *error);

/* The same from an open stream; `path` is for messages. */
mukca_status mukca_summary_read_stream(FILE *stream, const char *path, mukca_summary_fn *take,
                                       void *context, mukca_error *error);

#endif
