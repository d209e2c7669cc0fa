/* A whole text file in memory; the checked end of a stream. */
#ifndef MUKCA_BASE_FILE_H
#define MUKCA_BASE_FILE_H

#include <stdbool.h>
#include <stdio.h>

#include "mukca/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Read the file (`-`: standard input) into *text, ended by a zero byte; free it.  On failure *text
 * is NULL.  Errors: MUKCA_INPUT (cannot be read, a folder, larger than 32 MiB, holds a zero byte),
 * MUKCA_MEMORY. */
mukca_status mukca_file_read(char **text, const char *path, mukca_error *error);

/* Close a stream (NULL: none) and return whether everything was written to it: fclose forgets
 * earlier failures, and one of open_memstream can leave *text NULL.  `text` is NULL for a file. */
bool mukca_file_close(FILE *stream, char *const *text);

/* The path without its folder. */
const char *mukca_file_name(const char *path);

/* A path short enough for an error line: its last 100 characters. */
const char *mukca_file_shown(const char *path);

/* "PATH: cannot read: reason" by errno, with status MUKCA_INPUT or MUKCA_MEMORY. */
mukca_status mukca_file_fail(mukca_error *error, const char *path);

#ifdef __cplusplus
}
#endif
#endif
