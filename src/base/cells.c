/* Text tables in memory: lines, cells and numbers. */
#include "base/cells.h"

#include <string.h>

#include "base/number.h"

bool mukca_lines_next(mukca_lines *lines)
{
    const char *text = lines->text;
    if (lines->left == 0) return false;
    if (lines->number++ == 0 && lines->left >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0) {
        text += 3;
        lines->left -= 3;
    }
    size_t length = 0;
    while (length < lines->left && text[length] != '\n') length++;
    size_t kept = length < MUKCA_LINE_SIZE ? length : MUKCA_LINE_SIZE - 1;
    lines->whole = kept == length;
    memcpy(lines->line, text, kept);
    while (kept > 0 && lines->line[kept - 1] == '\r') kept--;
    lines->line[kept] = '\0';
    if (length < lines->left) length++; /* include the newline */
    lines->text = text + length;
    lines->left -= length;
    return true;
}

char mukca_cells_delimiter(const char *line)
{
    return strchr(line, '\t') ? '\t' : ',';
}

int mukca_cells_count(const char *line, char delimiter)
{
    int n = delimiter != ' ';
    if (delimiter == ' ')
        for (; *(line += strspn(line, " ")); line += strcspn(line, " ")) n++;
    else
        for (; *line; line++) n += *line == delimiter;
    return n;
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

/* Trim the cell that ends before `end`, in place; returns its start. */
static char *trim(char *cell, char *end)
{
    while (cell < end && is_blank(*cell)) cell++;
    while (cell < end && is_blank(end[-1])) end--;
    if (end - cell >= 2 && *cell == '"' && end[-1] == '"') cell++, end--;
    *end = '\0';
    return cell;
}

bool mukca_cells_split(char **cells, int n, char *line, char delimiter)
{
    int found = 0;
    char *c = line;
    if (delimiter == ' ') {
        if (mukca_cells_count(line, ' ') != n) return false;
        for (; found < n; c += strcspn(c, " ")) {
            if (found > 0) *c++ = '\0'; /* after the last word */
            c += strspn(c, " ");
            cells[found++] = c;
        }
        *c = '\0';
        return true;
    }
    for (char *start = line;; c++) { /* starts first: nothing changes in a line of another n */
        if (*c && *c != delimiter) continue;
        if (found == n) return false;
        cells[found++] = start;
        start = c + 1;
        if (!*c) break;
    }
    if (found != n) return false;
    for (int i = 0; i < n; i++) cells[i] = trim(cells[i], i + 1 < n ? cells[i + 1] - 1 : c);
    return true;
}

bool mukca_cell_number(double *value, const char *cell, char *fault)
{
    if (mukca_number_parse(value, cell)) return true;
    if (!*cell)
        mukca_print(fault, MUKCA_CELL_FAULT, "is empty; a number is required");
    else if (strchr(cell, ',') && strspn(cell, "+-0123456789,eE") == strlen(cell))
        mukca_print(fault, MUKCA_CELL_FAULT, "'%.30s' has a decimal comma; write a point", cell);
    else
        mukca_print(fault, MUKCA_CELL_FAULT, "'%.30s' is not a finite number", cell);
    return false;
}
