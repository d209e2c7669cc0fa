/* Names of the columns of tables from other programs. */
#ifndef MUKCA_IO_COLUMNS_H
#define MUKCA_IO_COLUMNS_H

#include "io/table.h"

/* Rename the columns of an open table by the text or file `columns`: `COLUMN=NAME,...`, or a name
 * for each column in order; a line end separates like a comma. */
mukca_status mukca_columns_rename(mukca_table *table, const char *columns, mukca_error *error);

#endif
