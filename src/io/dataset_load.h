/* Datasets from files: folders of hole_N.csv, session files, pose logs, in any combination. */
#ifndef MUKCA_IO_DATASET_LOAD_H
#define MUKCA_IO_DATASET_LOAD_H

#include "io/rows.h"
#include "model/dataset.h"

typedef struct {
    double distance;       /* between any two sockets of a placement, m; 0: 0.05 */
    const char *distances; /* table of distances by socket labels, replaces `distance`; or NULL */
    const double *payload; /* [n_paths] for samples whose file has no payload, kg; or NULL */
    mukca_rows_format format; /* of the tables */
    bool partial;        /* an unfinished session: sockets may be missing or have few samples */
    mukca_note_fn *note; /* may be NULL */
    void *context;
} mukca_dataset_options;

/* Read the files and folders (of a placement, or of such folders) paths[n_paths] in order into a
 * new dataset (free it with mukca_dataset_free).  Duplicate samples are removed (dataset_copies.h).
 * Sockets with fewer than 2 samples and placements with fewer than 2 sockets are dropped with a
 * note.  `options` may be NULL.  Errors: MUKCA_INPUT (file, line, column), MUKCA_MEMORY. */
mukca_status mukca_dataset_load(mukca_dataset *data, const mukca_chain *chain,
                                const char *const *paths, int n_paths,
                                const mukca_dataset_options *options, mukca_error *error);

#endif
