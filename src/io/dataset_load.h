/* Datasets from files: folders of hole_N.csv, session files, pose logs, in any combination. */
#ifndef MUKCA_IO_DATASET_LOAD_H
#define MUKCA_IO_DATASET_LOAD_H

#include "io/rows.h"
#include "mukca/dataset.h"

typedef struct {
    double distance;          /* m between any two sockets of a placement; 0: 0.05 */
    const char *distances;    /* instead: a table of distances by socket labels; or NULL */
    const double *payload;    /* [n_paths] kg, for rows whose file says nothing of it; or NULL */
    mukca_rows_format format; /* of the tables */
    bool partial;             /* a session in the making: sockets may be few or have few rows */
    mukca_note_fn *note;      /* may be NULL */
    void *context;
} mukca_dataset_options;

/* Read the files and folders (of a placement, or of such folders) paths[n_paths] in order into a
 * new dataset (mukca_dataset_free).  Rows that repeat others are dropped (dataset_copies.h).  Each
 * socket needs 2 rows, each placement 2 sockets: others are set aside with a note.  `options` may
 * be NULL. Errors: MUKCA_INPUT (file, line, column), MUKCA_MEMORY. */
mukca_status mukca_dataset_load(mukca_dataset *data, const mukca_chain *chain,
                                const char *const *paths, int n_paths,
                                const mukca_dataset_options *options, mukca_error *error);

#endif
