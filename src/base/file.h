/* Reading of whole text files, checked close of streams. */
#ifndef MUKCA_BASE_FILE_H
#define MUKCA_BASE_FILE_H

#include <stdbool.h>
#include <stdio.h>

#include "mukca/status.h"

/* Read the file (`-`: standard input) into *text, NUL-terminated; the caller frees it.  On failure
 * *text is NULL.  Errors: MUKCA_INPUT (not readable, a folder, larger than 32 MiB, contains a NUL
 * byte), MUKCA_MEMORY. */
mukca_status mukca_file_read(char **text, const char *path, mukca_error *error);

/* Close a stream (NULL: none) and return true if all output was written: fclose ignores earlier
 * failures, and open_memstream can leave *text NULL.  `text` is NULL for a file. */
bool mukca_file_close(FILE *stream, char *const *text);

/* File name of a path, without folder. */
const char *mukca_file_name(const char *path);

/* A path short enough for an error line: its last 100 characters. */
const char *mukca_file_shown(const char *path);

/* Error "PATH: cannot read: reason" from errno; status MUKCA_INPUT or MUKCA_MEMORY. */
mukca_status mukca_file_fail(mukca_error *error, const char *path);

#endif
