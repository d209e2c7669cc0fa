/* Recorded rows, one at a time: the columns of sessions and pose logs mapped to a chain.
 *
 * For readers that reduce rows as they come; whole datasets are read by dataset_load.h.
 */
#ifndef MUKCA_IO_ROWS_H
#define MUKCA_IO_ROWS_H

#include "io/table.h"
#include "mukca/row_state.h"

typedef struct {
    mukca_table_kind kind; /* a table without header has one column per joint and no other */
    mukca_note_fn *note;   /* may be NULL */
    void *context;
} mukca_rows_options;

/* Indices into the table's cells, -1 where a column is absent. */
typedef struct {
    int placement, socket, time, temperature, payload;
    int joint[MUKCA_MAX_JOINTS], effort[MUKCA_MAX_JOINTS], command[MUKCA_MAX_JOINTS],
        velocity[MUKCA_MAX_JOINTS];
    int position[3], quaternion[4]; /* all or none; w first */
} mukca_columns;

typedef struct {
    mukca_table table;
    const mukca_chain *chain;
    mukca_rows_options options;
    mukca_columns column;
    bool has_command;              /* for one joint at least */
    bool by_command;               /* no angles but the commanded ones */
    bool warned[MUKCA_MAX_JOINTS]; /* beyond its limits */
} mukca_rows;

/* One row; what the file lacks is NaN, texts are NULL.  Texts are valid until the next row. */
typedef struct {
    const char *placement, *socket;
    double q[MUKCA_MAX_JOINTS], effort[MUKCA_MAX_JOINTS], command[MUKCA_MAX_JOINTS],
        velocity[MUKCA_MAX_JOINTS];    /* rad or m, N m, rad, rad/s */
    double time, temperature, payload; /* s, degrees Celsius, kg */
    double position[3], quaternion[4]; /* m; normalised */
} mukca_row;

/* Open a table and find the chain's joints in its header.  A joint without a column is an error, an
 * unknown column a note.  `chain` must outlive the rows. */
mukca_status mukca_rows_open(mukca_rows *rows, const char *path, const mukca_chain *chain,
                             const mukca_rows_options *options, mukca_error *error);

/* Read and check one row: numbers, angles that look like degrees, positions that look like
 * millimetres, quaternions that are not normalised.  *more is false at the end. */
mukca_status mukca_rows_next(mukca_rows *rows, mukca_row *row, bool *more, mukca_error *error);

/* The row for the accumulator of row states; its placement is unknown.  It points into `row`. */
mukca_row_reading mukca_row_read(const mukca_row *row, const mukca_rows *rows);

void mukca_rows_close(mukca_rows *rows); /* harmless on a zeroed one */

/* Refuse a measured length that looks like millimetres. */
mukca_status mukca_rows_check_length(const mukca_table *table, int column, double metres,
                                     mukca_error *error);

/* Normalise a measured quaternion; false where its length is not 1 within 1 %. */
bool mukca_rows_normalise(double quaternion[4]);

#endif
