/* Text tables: TSV or CSV, `#` comments, with or without a header; read row by row.
 *
 * Semicolons may separate the cells; numbers may then have decimal commas.  Blanks separate them if
 * nothing else does.  Units in the header, as in `q1 [deg]`, are applied.  An array of numpy is a
 * table without header.  Cells are trimmed and surrounding double quotes removed; blank lines and a
 * byte-order mark are skipped; lines may end in CR LF.
 *
 * The first failure is kept: MUKCA_INPUT with file, line and column, or MUKCA_MEMORY.  After it
 * there are no more rows, and mukca_table_close returns it. */
#ifndef MUKCA_IO_TABLE_H
#define MUKCA_IO_TABLE_H

#include <stdbool.h>
#include <stdio.h>

#include "base/cells.h"
#include "base/pool.h"
#include "base/text.h"

enum {
    MUKCA_TABLE_LINE = 1 << 20, /* bytes: a longer line is of another kind of file */
    MUKCA_TABLE_COLUMNS = 4096, /* largest width; a session of 16 joints has about 90 */
    MUKCA_WHOLE_TABLE = -2      /* what mukca_table_fail refuses */
};

typedef enum { MUKCA_HEADER, MUKCA_NO_HEADER, MUKCA_EITHER } mukca_table_kind;

/* Rows from elsewhere than the stream. */
typedef struct mukca_table mukca_table;
typedef struct {
    bool (*next)(mukca_table *table);
    void (*close)(mukca_table *table);
} mukca_table_source;

struct mukca_table {
    char path[512];
    mukca_status status; /* of the first failure, with its message in */
    mukca_error *error;
    FILE *stream;
    int line;      /* of the current row, from 1 */
    int row;       /* data rows read so far */
    int n_columns; /* 0 before the first row of a table without header */
    char delimiter;
    bool cut_off;     /* the file does not end in a newline */
    bool pending;     /* the first row was read by mukca_table_open */
    mukca_pool pool;  /* of all memory below but `names` */
    char **header;    /* [n_columns], or NULL */
    char **cell;      /* [n_columns] of the current row */
    mukca_unit *unit; /* [n_columns] stated in the header; or NULL */
    bool *used;       /* [n_columns], columns asked for by mukca_table_use; or NULL */
    char *buffer;     /* of a line */
    char *names;      /* of --columns */
    char *comments;   /* lines before the header; without text, but counted, if they do not fit */
    mukca_table_source *source; /* NULL: the stream */
    const double *value;        /* [n_columns] cells as numbers, SI; NaN: not parsed; or NULL */
};

/* Open `path` (`-` is standard input) and read the header.  Kind EITHER: there is no header if the
 * first line has numbers only.  A table with a header may have no rows. */
mukca_status mukca_table_open(mukca_table *table, const char *path, mukca_table_kind kind,
                              mukca_error *error);

/* Read one row into table->cell; false: the end of the file, or a failure.  Rows must have equal
 * width. */
bool mukca_table_next(mukca_table *table);

/* Read the rows of a large file with a header ahead, in a thread: the rows are the same.  No effect
 * on other tables: a pipe's rows would come late. */
void mukca_table_read_ahead(mukca_table *table);

/* Returns the first failure, MUKCA_OK: none.  Harmless on a zeroed table. */
mukca_status mukca_table_close(mukca_table *table);

/* Index of a column by its name, -1: none. */
int mukca_table_find(const mukca_table *table, const char *name);

/* The same for a column that is going to be read, and for a required one. */
int mukca_table_use(mukca_table *table, const char *name);
int mukca_table_require(mukca_table *table, const char *name);

/* Whether the header states the column's unit: its numbers are then in SI units. */
bool mukca_table_has_unit(const mukca_table *table, int column);

/* Parse a cell as a finite number, in SI units if the header states its unit; false, or a failure
 * and 0, if it is none. */
bool mukca_table_parse(double *value, const mukca_table *table, int column);
double mukca_table_number(mukca_table *table, int column);

/* Fail with "file:line: column 'name': ..." and status MUKCA_INPUT; column -1: none;
 * MUKCA_WHOLE_TABLE: without a line, too.  And with another status, whose message is in
 * table->error already (MUKCA_OK: no failure). */
void mukca_table_fail(mukca_table *table, int column, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void mukca_table_stop(mukca_table *table, mukca_status status);

/* Append the names of all columns, or of those not used, with dots for those that do not fit;
 * returns their number. */
int mukca_table_list(mukca_text *list, const mukca_table *table, bool unused);

/* ---- names of columns (rows_header.c, columns.c) ---- */

/* Ends the names of columns by mukca capture with the standard deviations; not read. */
#define MUKCA_COLUMNS_SPREAD ".spread"

/* Whether a column of recordings has that name, which no joint may have. */
bool mukca_columns_reserved(const char *name);

/* Fail if two columns have one name. */
void mukca_table_check_names(mukca_table *table);

/* Rename the columns of an open table by the text or file `columns`: `COLUMN=NAME,...`, or a name
 * for each column in order; a line end separates like a comma.  A NAME may state the unit. */
void mukca_columns_rename(mukca_table *table, const char *columns);

#endif
