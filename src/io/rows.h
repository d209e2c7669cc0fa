/* Recorded rows, one at a time: the columns of sessions and pose logs mapped to a chain.
 *
 * For those that reduce rows as they read them; whole datasets are read by dataset_load.h.
 */
#ifndef MUKCA_IO_ROWS_H
#define MUKCA_IO_ROWS_H

#include "io/table.h"
#include "mukca/row_state.h"

/* Which columns a file has; indices into the table's cells, -1 where absent. */
typedef struct {
    mukca_table table;
    const mukca_chain *chain;
    mukca_note_fn *note;
    void *context;
    int placement, socket, time, temperature, payload;
    int joint[MUKCA_MAX_JOINTS], effort[MUKCA_MAX_JOINTS], command[MUKCA_MAX_JOINTS],
        velocity[MUKCA_MAX_JOINTS];
    int position[3], quaternion[4];             /* all or none; w first */
    bool has_effort, has_command, has_velocity; /* for one joint at least */
    bool warned[MUKCA_MAX_JOINTS];
} mukca_rows;

/* One row; what the file lacks is NaN, texts are NULL.  Texts are valid until the next row. */
typedef struct {
    const char *placement, *socket;
    double q[MUKCA_MAX_JOINTS], effort[MUKCA_MAX_JOINTS], command[MUKCA_MAX_JOINTS],
        velocity[MUKCA_MAX_JOINTS];
    double time, temperature, payload;
    double position[3], quaternion[4]; /* quaternion: normalised */
} mukca_row;

/* Open a table and find the chain's joints in its header (a table without header, where `kind`
 * allows one, must have exactly one column per joint).  A joint without a column is an error, a
 * column that means nothing a note.  `chain` must outlive the rows.  `note` may be NULL. */
mukca_status mukca_rows_open(mukca_rows *rows, const char *path, mukca_table_kind kind,
                             const mukca_chain *chain, mukca_note_fn *note, void *context,
                             mukca_error *error);

/* Read and check one row: numbers, angles that look like degrees, positions that look like
 * millimetres, quaternions that are not normalised.  *more is false at the end. */
mukca_status mukca_rows_next(mukca_rows *rows, mukca_row *row, bool *more, mukca_error *error);

/* The row for the accumulator of row states; its placement is unknown.  It points into `row`. */
mukca_row_reading mukca_row_read(const mukca_row *row, const mukca_rows *rows);

void mukca_rows_close(mukca_rows *rows); /* harmless on a zeroed one */

/* Normalise a measured quaternion; false where its length is not 1 within 1 %. */
bool mukca_rows_normalise(double quaternion[4]);

#endif
