/* Cells of a line of a table: splitting, trimming, numbers. */
#ifndef MUKCA_BASE_CELLS_H
#define MUKCA_BASE_CELLS_H

#include <stdbool.h>

/* Tab where the line has one, else comma. */
char mukca_cells_delimiter(const char *line);

int mukca_cells_count(const char *line, char delimiter);

/* Split `line` in place into exactly n cells, trimmed of blanks and surrounding double quotes;
 * false (and nothing changed) where it has more or fewer. */
bool mukca_cells_split(char **cells, int n, char *line, char delimiter);

enum { MUKCA_CELL_FAULT = 80 };

/* A cell as a finite number; false with the reason in fault[MUKCA_CELL_FAULT]. */
bool mukca_cell_number(double *value, const char *cell, char *fault);

#endif
