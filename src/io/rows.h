/* Recorded rows, one at a time: the columns of sessions and pose logs mapped to a chain.
 *
 * For readers that reduce rows as they come; whole datasets are read by dataset_load.h.
 */
#ifndef MUKCA_IO_ROWS_H
#define MUKCA_IO_ROWS_H

#include "io/quaternion_check.h"
#include "io/table.h"
#include "mukca/row_state.h"

/* How tables that others made are written; zeroed: as mukca writes them. */
typedef struct {
    double angle, length; /* rad and m of the file's units; 0: 1 */
    bool units;           /* they were given: columns x, y, z are positions */
    /* A table without header may hold poses: the joints in the chain's order, then x y z, then
     * nothing, qw qx qy qz, or instead of all of them the 16 numbers of a matrix. */
    bool by_order;
    bool w_last; /* in such a table: qx qy qz qw */
    bool
        inverse; /* poses of the measuring frame in the target's, as a camera on the arm has them */
} mukca_rows_format;

typedef struct {
    mukca_table_kind kind;
    mukca_rows_format format;
    bool any_order;      /* quaternions with w last are the caller's matter */
    mukca_note_fn *note; /* may be NULL */
    void *context;
} mukca_rows_options;

enum { MUKCA_ROWS_TARGETS = 16 }; /* measured in one line of a table */

/* How an orientation is written: qw qx qy qz; UR's rotation vector rx ry rz; roll pitch yaw as in
 * a URDF; KUKA's A B C, the same angles backwards. */
typedef enum {
    MUKCA_QUATERNION,
    MUKCA_ROTATION_VECTOR,
    MUKCA_ROLL_PITCH_YAW,
    MUKCA_ABC
} mukca_turn;

/* Columns of one measured target, -1 where absent; a matrix replaces the others. */
typedef struct {
    char target[MUKCA_NAME_SIZE];         /* L of columns x_m.L; "" of x_m */
    double length;                        /* m per unit of the positions */
    mukca_turn form;                      /* of the columns `turn`: 4 of a quaternion, else 3 */
    int position[3], turn[4], matrix[16]; /* each all or none; row by row */
} mukca_measured_columns;

/* Indices into the table's cells, -1 where a column is absent. */
typedef struct {
    int placement, socket, target, time, temperature, payload;
    int joint[MUKCA_MAX_JOINTS], effort[MUKCA_MAX_JOINTS], command[MUKCA_MAX_JOINTS],
        velocity[MUKCA_MAX_JOINTS];
    int n_measured;
    mukca_measured_columns measured[MUKCA_ROWS_TARGETS];
} mukca_row_columns;

typedef struct {
    mukca_table table;
    const mukca_chain *chain;
    mukca_rows_options options;
    mukca_row_columns column;
    bool has_command;              /* for one joint at least */
    bool by_command;               /* no angles but the commanded ones */
    bool warned[MUKCA_MAX_JOINTS]; /* beyond its limits */
    mukca_quaternion_check quaternions;
    int measured; /* targets of the current line that have been returned */
} mukca_rows;

/* One row; what the file lacks is NaN, texts are NULL.  Texts are valid until the next row. */
typedef struct {
    const char *placement, *socket, *target;
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
 * millimetres, quaternions that are not normalised.  A line that measures several targets gives a
 * row of each.  *more is false at the end. */
mukca_status mukca_rows_next(mukca_rows *rows, mukca_row *row, bool *more, mukca_error *error);

/* The row for the accumulator of row states; its placement is unknown.  It points into `row`. */
mukca_row_reading mukca_row_read(const mukca_row *row, const mukca_rows *rows);

void mukca_rows_close(mukca_rows *rows); /* harmless on a zeroed one */

/* Find the columns by the header, or by their order (part of mukca_rows_open). */
mukca_status mukca_rows_map(mukca_rows *rows, mukca_error *error);

/* Fail since no measured positions were found: those without a unit, or `otherwise`. */
mukca_status mukca_rows_fail_measured(const mukca_rows *rows, const char *otherwise,
                                      mukca_error *error);

/* kg: the strongest arms carry 2.3 t. */
#define MUKCA_ROWS_MOST_PAYLOAD 5e3

/* Refuse a measured length that looks like millimetres. */
mukca_status mukca_rows_check_length(const mukca_table *table, int column, double metres,
                                     mukca_error *error);

/* Normalise a measured quaternion; false where its length is not 1 within 1 %. */
bool mukca_rows_normalise(double quaternion[4]);

#endif
