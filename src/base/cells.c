/* Tables of text in memory. */
#include "base/cells.h"

#include <stdio.h>
#include <string.h>

#include "base/number.h"

bool mukca_lines_next(mukca_lines *lines)
{
    if (!*lines->text) return false;
    if (lines->number++ == 0 && strncmp(lines->text, "\xEF\xBB\xBF", 3) == 0) lines->text += 3;
    const size_t length = strcspn(lines->text, "\n");
    size_t kept = length < MUKCA_LINE_SIZE ? length : MUKCA_LINE_SIZE - 1;
    lines->whole = kept == length;
    memcpy(lines->line, lines->text, kept);
    while (kept > 0 && lines->line[kept - 1] == '\r') kept--;
    lines->line[kept] = '\0';
    lines->text += length + (lines->text[length] == '\n');
    return true;
}

char mukca_cells_delimiter(const char *line)
{
    return strchr(line, '\t') ? '\t' : ',';
}

int mukca_cells_count(const char *line, char delimiter)
{
    int n = 1;
    for (; *line; line++) n += *line == delimiter;
    return n;
}

/* Trim in place; returns the start. */
static char *trim(char *cell)
{
    cell += strspn(cell, " \t\r");
    size_t length = strlen(cell);
    while (length && strchr(" \t\r", cell[length - 1])) cell[--length] = '\0';
    if (length >= 2 && cell[0] == '"' && cell[length - 1] == '"') {
        cell[length - 1] = '\0';
        cell++;
    }
    return cell;
}

bool mukca_cells_split(char **cells, int n, char *line, char delimiter)
{
    if (mukca_cells_count(line, delimiter) != n) return false;
    for (int i = 0; i < n; i++) {
        char *end = strchr(line, delimiter);
        if (end) *end = '\0';
        cells[i] = trim(line);
        line = end ? end + 1 : line;
    }
    return true;
}

bool mukca_cell_number(double *value, const char *cell, char *fault)
{
    if (mukca_number_parse(value, cell)) return true;
    if (!*cell)
        snprintf(fault, MUKCA_CELL_FAULT, "is empty; a number is required");
    else if (strchr(cell, ',') && strspn(cell, "+-0123456789,eE") == strlen(cell))
        snprintf(fault, MUKCA_CELL_FAULT, "'%.30s' has a decimal comma; write a point", cell);
    else
        snprintf(fault, MUKCA_CELL_FAULT, "'%.30s' is not a finite number", cell);
    return false;
}
