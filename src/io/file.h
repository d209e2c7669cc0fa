/* A whole file as bytes in memory. */
#ifndef MUKCA_IO_FILE_H
#define MUKCA_IO_FILE_H

#include <stddef.h>

#include "mukca/status.h"

/* 64 MiB: no URDF, table or type description comes near it. */
#define MUKCA_FILE_LARGEST ((size_t)1 << 26)

/* Read the file into *text (free it), its length into *length; a zero byte follows it.  On failure
 * *text is NULL.  Errors: MUKCA_INPUT (cannot be read, a folder, larger than `most` bytes),
 * MUKCA_MEMORY. */
mukca_status mukca_file_read(char **text, size_t *length, const char *path, size_t most,
                             mukca_error *error);

#endif
