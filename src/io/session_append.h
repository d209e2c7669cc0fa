/* A session file that grows while it is recorded: each row is on disk before it is acknowledged. */
#ifndef MUKCA_IO_SESSION_APPEND_H
#define MUKCA_IO_SESSION_APPEND_H

#include <stdbool.h>
#include <stdint.h>

#include "mukca/chain.h"
#include "mukca/status.h"

/* The header of a session. */
typedef struct {
    const mukca_chain *chain;
    const char *stream;  /* "raw" or "corrected" */
    const char *channel; /* where the joint states came from */
    const char *type;
    bool has_effort, has_command; /* columns */
} mukca_session_head;

/* One sample.  Arrays of n_joints in the chain's order; effort and command where the head has
 * them. */
typedef struct {
    const char *placement, *socket;
    double time; /* s */
    const double *q, *spread, *effort, *command;
} mukca_session_row;

/* Zeroed: closed. */
typedef struct {
    int fd; /* + 1, so that zero is closed */
    char path[1024];
    char separator;
    int n_joints;
    bool has_effort, has_command;
    int64_t length;  /* of the acknowledged text, bytes */
    bool uncut;      /* more may follow it: of a row that could not be written */
    int n_rows;      /* recorded and not undone */
    int64_t *row_at; /* [n_rows] where each begins */
    int capacity;
} mukca_session;

/* Begin a session; `path` must not exist, unless `force` overwrites it.  A name that ends in .csv
 * gives commas, any other tabs.
 * Errors: MUKCA_INPUT (exists, cannot be written, in use by another program), MUKCA_MEMORY (also:
 * could not be written whole). */
mukca_status mukca_session_create(mukca_session *session, const char *path, bool force,
                                  const mukca_session_head *head, mukca_error *error);

/* Continue a session; a file that does not exist, or is empty, is begun.  The rest of a row that a
 * crash or a power cut left unacknowledged is removed with a `note`.
 * Errors: as above; another robot's, other columns, the other kind of stream. */
mukca_status mukca_session_resume(mukca_session *session, const char *path,
                                  const mukca_session_head *head, mukca_note_fn *note,
                                  void *note_context, mukca_error *error);

/* Append a row and put it on disk; after a failure the file is as before.  Errors: MUKCA_MEMORY. */
mukca_status mukca_session_add(mukca_session *session, const mukca_session_row *row,
                               mukca_error *error);

/* Undo the last row: it becomes a comment, and a second comment records that.
 * Errors: MUKCA_INPUT (no row), MUKCA_MEMORY (cannot be written; the row stays). */
mukca_status mukca_session_undo(mukca_session *session, const char *placement, const char *socket,
                                mukca_error *error);

/* Whether `label` may be written to a session: 1 to 63 printable bytes of UTF-8, no separator, no
 * leading #. */
bool mukca_session_label_ok(const char *label);

/* Harmless on a closed one. */
void mukca_session_close(mukca_session *session);

#endif
