/* Recorded rows, one at a time: the columns of sessions and pose logs mapped to a chain.
 *
 * For readers that process rows one by one; dataset.h reads whole datasets. */
#ifndef MUKCA_IO_ROWS_H
#define MUKCA_IO_ROWS_H

#include <math.h>

#include "io/rotations.h"
#include "io/table.h"
#include "model/dataset_subset.h"
#include "mukca/row_state.h"

/* Format of tables from other programs; zeroed: mukca's own. */
typedef struct {
    double angle, length; /* rad and m per unit of the file; 0: 1 */
    bool units;           /* the user stated units: columns x, y, z are positions */
    const char *columns;  /* --columns: names of columns, or the file of such; NULL: none */
    /* a table without header may have poses: the joints in the chain's order, then x y z, then
     * nothing or qw qx qy qz; or the 16 numbers of a matrix instead */
    bool by_order;
    mukca_rotation_form rotation; /* --rotation */
    bool inverse; /* poses are those of the measuring frame in the target's frame, as of a camera on
                     the arm */
} mukca_rows_format;

typedef struct {
    mukca_table_kind kind;
    mukca_rows_format format;
    bool unchecked; /* poses need not be those of the joints */
    bool currents;  /* columns JOINT.current stand for absent efforts */
    mukca_notes notes;
    bool *warned; /* [MUKCA_MAX_JOINTS] joints beyond their limits in other tables; may be NULL */
} mukca_rows_options;

enum { MUKCA_ROWS_TARGETS = 16 }; /* largest number of targets per line */

/* Columns of one measured target, -1 if absent; a matrix replaces the others. */
typedef struct {
    char target[MUKCA_NAME_SIZE]; /* L of columns x_m.L; "" for x_m */
    double length;                /* m per unit of the positions */
    int position[3], turn[4];     /* complete or absent; turn: qw qx qy qz, or three numbers */
    const char *form;             /* convention of the three (math/angles.h) */
    int matrix[16];               /* row-major; the last row may be absent */
} mukca_measured_columns;

/* Indices of the table's columns, -1 if absent. */
typedef struct {
    int placement, socket, target;
    int number[MUKCA_COLUMNS][MUKCA_MAX_JOINTS]; /* by joint; [0] of a column that is no joint's;
                                                    those of poses are in `measured` */
    int n_measured;
    mukca_measured_columns measured[MUKCA_ROWS_TARGETS];
} mukca_row_columns;

typedef struct {
    mukca_table table;
    const mukca_chain *chain;
    mukca_rows_options options;
    mukca_row_columns column;
    bool has_command;                  /* of at least one joint */
    bool has_current;                  /* the efforts are currents, A */
    bool by_command;                   /* commanded angles only, without measured ones */
    bool warned[MUKCA_MAX_JOINTS];     /* a note of exceeded limits was printed */
    mukca_rotation_samples *rotations; /* NULL: no orientation was read */
    int measured;                      /* number of targets of the current line already returned */
} mukca_rows;

/* One row; missing values are NaN, missing texts NULL.  Texts are valid until the next row. */
typedef struct {
    const char *placement, *socket, *target;
    union {
        struct {
#define MUKCA_ROW_MEMBER(constant, member, ...) double member[MUKCA_MAX_JOINTS];
            MUKCA_COLUMN_LIST(MUKCA_ROW_MEMBER) /* SI; as many as the column's width */
#undef MUKCA_ROW_MEMBER
        };
        double number[MUKCA_COLUMNS][MUKCA_MAX_JOINTS]; /* the same */
    };
} mukca_row;
_Static_assert(MUKCA_MAX_JOINTS >= 4, "a member has room for a quaternion");

/* Open a table and find the chain's joints in its header.  A joint without a column
 * is an error, an unknown column is noted.  `chain` must outlive the rows. */
mukca_status mukca_rows_open(mukca_rows *rows, const char *path, const mukca_chain *chain,
                             const mukca_rows_options *options, mukca_error *error);

/* Read and check one row; false: the end, or a failure: not a number, angles that appear to be
 * degrees, positions that appear to be millimetres, quaternions not of length 1.  A line with
 * several targets yields a row for each. */
bool mukca_rows_next(mukca_rows *rows, mukca_row *row);

/* Convert the row for mukca_row_state_next, without placement.  The result points into `row`. */
mukca_row_reading mukca_row_read(const mukca_row *row, const mukca_rows *rows);

/* Returns the first failure; harmless on zeroed rows. */
mukca_status mukca_rows_close(mukca_rows *rows);

/* Map the columns by the header or by their order (part of mukca_rows_open). */
void mukca_rows_map(mukca_rows *rows);

/* Largest payload, kg: the strongest arms carry 2.3 t. */
#define MUKCA_ROWS_MOST_PAYLOAD 5e3

/* Larger angles, rad, are in degrees: a joint turns at most once or twice.  A value of 13 degrees
 * or less passes, but some row of a recording exceeds it.  Larger lengths of a joint, m, are in
 * millimetres: no linear axis is 20 m long. */
#define MUKCA_ROWS_MOST_ANGLE (4 * M_PI + 1e-6)
static inline bool mukca_rows_plausible(const mukca_element *joint, double q)
{
    return fabs(q) <= (joint->type == MUKCA_PRISMATIC ? 20 : MUKCA_ROWS_MOST_ANGLE);
}

/* How far q is beyond the joint's limits; 0 up to 0.05 rad or m: encoders exceed them slightly. */
static inline double mukca_rows_beyond(const mukca_element *joint, double q)
{
    const double beyond = fmax(q - joint->upper, joint->lower - q);
    return beyond > 0.05 ? beyond : 0;
}

/* Refuse a measured length that appears to be in millimetres. */
void mukca_rows_check_length(mukca_table *table, int column, double metres);

#endif
