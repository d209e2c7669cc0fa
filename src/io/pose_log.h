/* Pose logs from text files, which are parsed once, row by row. */
#ifndef MUKCA_IO_POSE_LOG_H
#define MUKCA_IO_POSE_LOG_H

#include "io/rows.h"
#include "recalibrate/recalibrate.h"

typedef struct {
    const char *const *paths; /* TSV or CSV with header */
    int n_paths, first_file;  /* first_file: `file` of the rows of the first one */
    mukca_rows_format format;
    mukca_note_fn *note; /* may be NULL */
    void *context;
    bool (*stop)(void); /* true aborts with MUKCA_INTERRUPTED; may be NULL */
} mukca_pose_files;

/* Append their rows that have a position.  Errors: MUKCA_INPUT (file and line; a second target),
 * MUKCA_INTERRUPTED, MUKCA_MEMORY. */
mukca_status mukca_pose_log_read(mukca_pose_log *log, const mukca_pose_files *files,
                                 const mukca_chain *chain, mukca_error *error);

#endif
