/* Tables of text in memory: lines, cells and numbers. */
#ifndef MUKCA_BASE_CELLS_H
#define MUKCA_BASE_CELLS_H

#include <stdbool.h>
#include <stddef.h>

enum { MUKCA_LINE_SIZE = 1024, MUKCA_CELL_FAULT = 80 };

/* The lines of a text; start with {.text = ..., .left = its bytes}. */
typedef struct {
    const char *text; /* what is still to be read, */
    size_t left;      /* bytes */
    int number;       /* of the current line, 1-based */
    bool whole;       /* false: the line was longer than MUKCA_LINE_SIZE and is cut */
    char line[MUKCA_LINE_SIZE];
} mukca_lines;

/* The next line, without its end and a byte-order mark; false at the end of the text. */
bool mukca_lines_next(mukca_lines *lines);

/* Tab where the line has one, else comma. */
char mukca_cells_delimiter(const char *line);

int mukca_cells_count(const char *line, char delimiter);

/* Split `line` in place into exactly n cells, trimmed of blanks and surrounding double quotes;
 * false (and nothing changed) where it has more or fewer. */
bool mukca_cells_split(char **cells, int n, char *line, char delimiter);

/* A cell as a finite number; false with the reason in fault[MUKCA_CELL_FAULT]. */
bool mukca_cell_number(double *value, const char *cell, char *fault);

#endif
