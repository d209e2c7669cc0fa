/* A session file that grows while it is recorded; each row is on disk before it is acknowledged. */
#ifndef MUKCA_IO_SESSION_APPEND_H
#define MUKCA_IO_SESSION_APPEND_H

#include <stdbool.h>
#include <stdint.h>

#include "capture/capture.h"
#include "mukca/chain.h"
#include "mukca/status.h"

enum { MUKCA_SESSION_LINE = 8192 }; /* bytes of a row, or of the header */

/* Zeroed: closed. */
typedef struct {
    bool open;
    int fd;                          /* if open; -1: the file does not exist yet */
    char header[MUKCA_SESSION_LINE]; /* to be written with the first sample; "": it was */
    char path[1024];
    char separator;
    const mukca_chain *chain;
    bool has_effort, has_command;
    int64_t length;  /* bytes acknowledged */
    bool uncut;      /* the file may have more bytes, of a row that failed */
    int n_rows;      /* recorded and not undone */
    int64_t *row_at; /* [n_rows] byte offsets of the rows */
} mukca_session;

/* What to open: a session file, which exists already only with `resume` (a partial row, left by a
 * crash or a power cut, is removed with a `note`) or `force` (the first sample overwrites it).  A
 * name that ends in .csv selects commas, any other tabs. */
typedef struct {
    const char *path;
    bool resume, force;
    const mukca_chain *chain;
    const char *stream;           /* "raw" or "corrected" */
    const char *channel, *type;   /* source of the joint states */
    bool has_effort, has_command; /* optional columns */
    mukca_notes notes;
} mukca_session_task;

/* The file is created with the first sample.  Errors: MUKCA_INPUT (exists, cannot be written, in
 * use by another program; to be resumed, but of another robot, with other columns or of the other
 * kind of stream), MUKCA_MEMORY (also: incomplete). */
mukca_status mukca_session_open(mukca_session *session, const mukca_session_task *task,
                                mukca_error *error);

/* Append a sample and sync it; on failure the file is unchanged.  Errors: MUKCA_MEMORY (also: the
 * file was changed, moved or deleted; one that is gone is written again). */
mukca_status mukca_session_add(mukca_session *session, const char *placement, const char *socket,
                               const mukca_capture_sample *sample, mukca_error *error);

/* Delete the last row.  It becomes a comment, and a comment at the end of the file records this.
 * Errors: MUKCA_INPUT (no row), MUKCA_MEMORY (write failure; the row
 * remains). */
mukca_status mukca_session_delete(mukca_session *session, const char *placement, const char *socket,
                                  mukca_error *error);

/* Whether `label` is valid in a session file: 1 to 63 printable bytes of UTF-8, no separator, no
 * leading #. */
bool mukca_session_label_ok(const char *label);

/* Harmless on a closed session. */
void mukca_session_close(mukca_session *session);

#endif
