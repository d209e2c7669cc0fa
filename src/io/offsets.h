/* The offsets table as a file. */
#ifndef MUKCA_IO_OFFSETS_H
#define MUKCA_IO_OFFSETS_H

#include <stdio.h>

#include "arm/offsets.h"

/* Write the table.  `data` (may be NULL) names the files that it came from; `comments` (may be
 * NULL) is text whose lines are added as `#` lines. */
mukca_status mukca_offsets_write(FILE *stream, const mukca_offsets *offsets,
                                 const mukca_chain *chain, const mukca_dataset *data,
                                 const char *comments, mukca_error *error);

/* Zeroed: the arm's own table, accepted, no notes. */
typedef struct {
    bool force;         /* take that of another URDF, too */
    bool accept_failed; /* take one that did not pass, too */
    mukca_note_fn *note;
    void *context; /* of note */
} mukca_offsets_options;

/* Read the table at `path` (mukca_offsets_parse); a note says where it was made for another URDF,
 * has rows of joints that are not in the chain, has no verdict, or did not pass.  Errors:
 * MUKCA_INPUT (file, line, column; did not pass), MUKCA_MEMORY. */
mukca_status mukca_offsets_read(mukca_offsets *offsets, const mukca_chain *chain, const char *path,
                                const mukca_offsets_options *options, mukca_error *error);

/* UTC time for provenance, "2026-01-31T12:00:00Z"; SOURCE_DATE_EPOCH is honoured. */
void mukca_offsets_time(char text[32]);

#endif
