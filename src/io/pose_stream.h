/* Pose logs read from files row by row, as often as needed, in constant memory: the text is parsed
 * once, its rows are kept in a temporary file. */
#ifndef MUKCA_IO_POSE_STREAM_H
#define MUKCA_IO_POSE_STREAM_H

#include <stdio.h>

#include "io/rows.h"
#include "recalibrate/pose_log.h"

/* Of the temporary file, bytes; a longer log (5 million rows of seven joints) is parsed anew each
 * time, as where no temporary file can be written. */
#define MUKCA_POSE_STREAM_KEPT 1e9

typedef struct {
    /* set by the caller; all must outlive the log */
    const char *const *paths; /* TSV or CSV with header */
    int n_paths;
    const mukca_chain *chain;
    mukca_rows_format format;
    mukca_note_fn *note; /* of the first reading only; may be NULL */
    void *context;
    /* internal */
    int at; /* the file being parsed */
    mukca_rows rows;
    bool open, noted;
    bool named; /* `target` is the first row's */
    char target[MUKCA_NAME_SIZE];
    bool full;            /* no temporary file can be had */
    FILE *kept;           /* rows parsed so far, or NULL */
    char buffer[1 << 16]; /* its */
    long n_kept, next;    /* rows; the next one to return */
} mukca_pose_stream;

/* A log of the pose logs of `stream`.  Rows without a position are skipped.  Close the stream
 * afterwards. */
void mukca_pose_stream_start(mukca_pose_log *log, mukca_pose_stream *stream);

void mukca_pose_stream_close(mukca_pose_stream *stream); /* harmless on a zeroed one */

#endif
