/* Tables of text: TSV or CSV, `#` comments, with a header or without; read row by row.
 *
 * Cells may be separated by semicolons; their numbers may then have decimal commas.  Cells are
 * trimmed and freed of surrounding double quotes; blank lines and a byte-order mark are skipped;
 * lines may end in CR LF.  All errors are MUKCA_INPUT and name file, line and column.
 */
#ifndef MUKCA_IO_TABLE_H
#define MUKCA_IO_TABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "mukca/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    MUKCA_TABLE_COLUMNS = 4096, /* at most; a session of 16 joints has about 90 */
    MUKCA_TABLE_NAMED = 8       /* columns that mukca_table_read can require */
};

typedef enum { MUKCA_HEADER, MUKCA_NO_HEADER, MUKCA_EITHER } mukca_table_kind;

typedef struct {
    char path[512];
    FILE *stream;
    int line;      /* of the current row, 1-based */
    int row;       /* data rows read so far */
    int n_columns; /* 0 before the first row of a table without header */
    char delimiter;
    bool cut_off;  /* the file ends without a newline */
    bool pending;  /* the first row has been read already */
    char **header; /* [n_columns], or NULL */
    char **cell;   /* [n_columns] of the current row */
    char *buffer, *header_buffer;
    char comments[4096]; /* `#` lines before the header, one a line, as many as fit */
} mukca_table;

/* Open `path` (`-` is standard input) and read the header, where the table has one; EITHER: it has
 * none where its first line holds nothing but numbers.  A table with a header may hold no rows. */
mukca_status mukca_table_open(mukca_table *table, const char *path, mukca_table_kind kind,
                              mukca_error *error);

/* Read one row into table->cell; *more is false at the end of the file.  Rows of another width than
 * the first are errors. */
mukca_status mukca_table_next(mukca_table *table, bool *more, mukca_error *error);

void mukca_table_close(mukca_table *table); /* harmless on a zeroed one */

/* Index of a column by its name, -1 where there is none. */
int mukca_table_find(const mukca_table *table, const char *name);

/* The same, where the column must be there. */
mukca_status mukca_table_require(int *column, const mukca_table *table, const char *name,
                                 mukca_error *error);

/* A cell as a finite number. */
mukca_status mukca_table_number(double *value, const mukca_table *table, int column,
                                mukca_error *error);

/* "file:line: column 'name': ..." with status MUKCA_INPUT; column -1: none. */
mukca_status mukca_table_fail(mukca_error *error, const mukca_table *table, int column,
                              const char *format, ...) __attribute__((format(printf, 4, 5)));

/* Note the columns with known[i] false: they are ignored. */
void mukca_table_note_unknown(const mukca_table *table, const bool *known, mukca_note_fn *note,
                              void *context);

/* Take in the current row; column[i] is the index of the i-th required column. */
typedef mukca_status mukca_table_row_fn(void *context, const mukca_table *table, const int *column,
                                        mukca_error *error);

/* Read the whole table `path`, whose header must have the columns names[n] (at most
 * MUKCA_TABLE_NAMED; names NULL: a table without header). */
mukca_status mukca_table_read(const char *path, const char *const *names, int n,
                              mukca_table_row_fn *read, void *context, mukca_error *error);

#ifdef __cplusplus
}
#endif
#endif
