/* Pose logs from files, row by row, for any number of passes in constant memory: the text is parsed
 * once, and its rows are stored in a temporary file. */
#ifndef MUKCA_IO_POSE_STREAM_H
#define MUKCA_IO_POSE_STREAM_H

#include <stdio.h>

#include "io/rows.h"
#include "recalibrate/recalibrate.h"

/* Largest size of the temporary file, bytes.  A longer log (3 million rows), or any log if no
 * temporary file can be written, is parsed again in each pass. */
#define MUKCA_POSE_STREAM_KEPT 1e9

typedef struct {
    /* set by the caller; all must outlive the log */
    const char *const *paths; /* TSV or CSV with header */
    int n_paths;
    const mukca_chain *chain;
    mukca_rows_format format;
    mukca_note_fn *note; /* during the first pass only; may be NULL */
    void *context;
    /* internal */
    int at; /* index of the file being parsed */
    mukca_rows rows;
    bool open, noted;
    bool named; /* `target` is set, from the first row */
    char target[MUKCA_NAME_SIZE];
    bool full;            /* no temporary file is available */
    FILE *kept;           /* rows parsed so far, or NULL */
    char buffer[1 << 16]; /* of `kept` */
    long n_kept, next;    /* rows stored; index of the next one to return */
} mukca_pose_stream;

/* Create a log that reads the pose logs of `stream`.  Rows without a position are skipped.  Close
 * the stream afterwards. */
void mukca_pose_stream_start(mukca_pose_log *log, mukca_pose_stream *stream);

void mukca_pose_stream_close(mukca_pose_stream *stream); /* harmless on a zeroed stream */

#endif
