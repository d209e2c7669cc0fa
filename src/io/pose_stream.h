/* Pose logs read from files row by row, as often as needed, in constant memory. */
#ifndef MUKCA_IO_POSE_STREAM_H
#define MUKCA_IO_POSE_STREAM_H

#include "io/rows.h"
#include "recalibrate/pose_log.h"

typedef struct {
    const char *const *paths;
    int n_paths, at; /* at: the file being read */
    const mukca_chain *chain;
    mukca_note_fn *note; /* of the first reading only */
    void *context;
    mukca_rows rows;
    bool open, noted;
} mukca_pose_stream;

/* A log of the pose logs paths[n_paths] (TSV or CSV with header); all must outlive it.  Rows
 * without a position are skipped.  `note` may be NULL.  Close the stream afterwards. */
void mukca_pose_stream_start(mukca_pose_log *log, mukca_pose_stream *stream,
                             const char *const *paths, int n_paths, const mukca_chain *chain,
                             mukca_note_fn *note, void *context);

void mukca_pose_stream_close(mukca_pose_stream *stream); /* harmless on a zeroed one */

#endif
