/* Files written whole or not at all: a temporary file in the same folder, fsync,
 * rename, fsync of the folder. */
#ifndef MUKCA_IO_OUTPUT_H
#define MUKCA_IO_OUTPUT_H

#include <stdbool.h>
#include <stdio.h>

#include "mukca/status.h"

typedef struct {
    FILE *stream;         /* write here; NULL while closed */
    char path[1024];      /* what the user asked for, links followed */
    char temporary[1080]; /* empty: written in place (standard output, a device) */
    bool force;           /* replace a file that exists */
} mukca_output;

/* Check that mukca_output_open(path) will succeed, without leaving a file: call it before long
 * work. */
mukca_status mukca_output_check(const char *path, bool force, mukca_error *error);

/* Do both name one regular file, or both standard output?  Neither need exist; NULL names none. */
bool mukca_output_same(const char *a, const char *b);

/* Open `path` for writing; `-` is standard output, devices and pipes are written directly.  Without
 * `force` an existing file is refused.  Errors: MUKCA_INPUT, MUKCA_MEMORY. */
mukca_status mukca_output_open(mukca_output *output, const char *path, bool force,
                               mukca_error *error);

/* Flush, sync and put in place; on failure nothing of it remains and an old file is as it was.
 * Writes that failed earlier are detected here.  Errors: MUKCA_MEMORY (not written whole),
 * MUKCA_INPUT (the file exists by now). */
mukca_status mukca_output_close(mukca_output *output, mukca_error *error);

/* Status of a file that cannot be written, by errno: MUKCA_MEMORY where room, memory or the disk is
 * at fault, else MUKCA_INPUT. */
mukca_status mukca_output_status(int reason);

/* Flush; false where anything was not written, also earlier: errno is the reason. */
bool mukca_output_flush(FILE *stream);

/* Put the entry of the file `path` in its folder on disk; false: errno is the reason. */
bool mukca_output_sync_folder(const char *path);

/* Lock an open file against other programs; false: another one has it.  One that is killed while it
 * starts a calculation leaves the lock to the child until that has begun: waits for 1 s. */
bool mukca_output_lock(int file);

/* Leave nothing behind; harmless on a zeroed or closed one. */
void mukca_output_abort(mukca_output *output);

/* Close an open output where all went well until now, else abort it; returns the first error. */
mukca_status mukca_output_finish(mukca_output *output, mukca_status status, mukca_error *error);

#endif
