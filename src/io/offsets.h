/* Offsets tables as files. */
#ifndef MUKCA_IO_OFFSETS_H
#define MUKCA_IO_OFFSETS_H

#include <stdio.h>

#include "arm/offsets.h"

/* Write the table.  `data` (may be NULL) has the names of its source files; `comments` (may be
 * NULL) is text whose lines are added as `#` lines. */
mukca_status mukca_offsets_write(FILE *stream, const mukca_offsets *offsets,
                                 const mukca_chain *chain, const mukca_dataset *data,
                                 const char *comments, mukca_error *error);

/* Zeroed: the table must be of this arm and accepted; no notes. */
typedef struct {
    int accept;            /* MUKCA_ACCEPT_* */
    mukca_chain *embedded; /* out: the chain in the table's comments, for which it is then read */
    mukca_notes notes;
} mukca_offsets_options;

/* Read the table at `path` (mukca_offsets_parse).  Notes: made for another URDF, rows of joints
 * that are not in the chain, no verdict, not accepted, no digest.  Errors: MUKCA_INPUT (file, line,
 * column; not accepted), MUKCA_MEMORY. */
mukca_status mukca_offsets_read(mukca_offsets *offsets, const mukca_chain *chain, const char *path,
                                const mukca_offsets_options *options, mukca_error *error);

/* Note each effect that is no function of the posture, with its size, and its `treatment`. */
void mukca_offsets_note_history(const mukca_offsets *offsets, const mukca_chain *chain,
                                const char *treatment, mukca_notes notes);

/* UTC time for provenance, "2026-01-31T12:00:00Z"; SOURCE_DATE_EPOCH overrides the clock. */
void mukca_offsets_time(char text[32]);

#endif
