/* Text tables in memory: lines, cells and numbers. */
#ifndef MUKCA_BASE_CELLS_H
#define MUKCA_BASE_CELLS_H

#include <stdbool.h>
#include <stddef.h>

enum { MUKCA_LINE_SIZE = 1024, MUKCA_CELL_FAULT = 80 };

/* Iterator over the lines of a text; start with {.text = ..., .left = its bytes}. */
typedef struct {
    const char *text; /* rest of the text, */
    size_t left;      /* bytes */
    int number;       /* of the current line, 1-based */
    bool whole;       /* false: truncated, longer than MUKCA_LINE_SIZE */
    char line[MUKCA_LINE_SIZE];
} mukca_lines;

/* Read the next line, without line end and byte-order mark; false at the end of the text. */
bool mukca_lines_next(mukca_lines *lines);

/* Tab if the line contains one, else comma.  A blank as delimiter stands for one or more. */
char mukca_cells_delimiter(const char *line);

int mukca_cells_count(const char *line, char delimiter);

/* Split `line` in place into exactly n cells, trimmed of blanks and surrounding double quotes;
 * false (line unchanged) if it has more or fewer. */
bool mukca_cells_split(char **cells, int n, char *line, char delimiter);

/* Parse a cell as a finite number; false: reason in fault[MUKCA_CELL_FAULT]. */
bool mukca_cell_number(double *value, const char *cell, char *fault);

/* ---- units in the names of columns ---- */

/* A unit: SI units per unit, 0: none; of an angle (a), length (l), time (t), mass (m), torque (N),
 * temperature (C) or rate (r). */
typedef struct {
    double factor;
    char of;
} mukca_unit;

/* Remove a unit at the end of a column's name, such as ` [deg]` or ` (mm)`, and return it. */
mukca_unit mukca_unit_take(char *name);

#endif
