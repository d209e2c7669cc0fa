/* Atomic output: files appear complete or not at all.  Temporary file in the same folder, fsync,
 * rename, fsync of the folder. */
#ifndef MUKCA_IO_OUTPUT_H
#define MUKCA_IO_OUTPUT_H

#include <stdbool.h>
#include <stdio.h>

#include "mukca/status.h"

typedef struct {
    FILE *stream;         /* of the caller's output; NULL while closed */
    char path[1024];      /* the user's path, links resolved */
    char temporary[1080]; /* empty: the file is written directly (standard output, a device) */
    bool force;           /* replace an existing file */
} mukca_output;

/* Check that mukca_output_open(path) will succeed, without leaving a file; call this before long
 * computations. */
mukca_status mukca_output_check(const char *path, bool force, mukca_error *error);

/* Whether both name the same regular file, or both standard output.  The files need not exist; NULL
 * equals nothing. */
bool mukca_output_same(const char *a, const char *b);

/* Open `path` for writing; `-` is standard output; devices and pipes are written directly.  Without
 * `force` an existing file is refused.  Errors: MUKCA_INPUT, MUKCA_MEMORY. */
mukca_status mukca_output_open(mukca_output *output, const char *path, bool force,
                               mukca_error *error);

/* Flush, sync and rename into place; on failure the temporary file is removed and an existing file
 * is unchanged.  Detects earlier write failures, too.  Errors: MUKCA_MEMORY (incomplete),
 * MUKCA_INPUT (the file was created meanwhile). */
mukca_status mukca_output_close(mukca_output *output, mukca_error *error);

/* Status of a write failure by errno: MUKCA_MEMORY for lack of space or memory and for disk errors,
 * else MUKCA_INPUT. */
mukca_status mukca_output_status(int reason);

/* Flush; false if any write failed, also an earlier one; errno has the reason. */
bool mukca_output_flush(FILE *stream);

/* Sync the directory entry of the file `path`; false: errno has the reason. */
bool mukca_output_sync_folder(const char *path);

/* Lock an open file against other programs; false: locked by another.  Waits for up to 1 s: a
 * program killed while it starts a job leaves the lock to the child until the child's exec. */
bool mukca_output_lock(int file);

/* Close an open output if `status` is MUKCA_OK, else remove its temporary file; returns the first
 * error.  Harmless on a zeroed or closed output. */
mukca_status mukca_output_finish(mukca_output *output, mukca_status status, mukca_error *error);

#endif
