/* Numbers in lines of robot programs, found by patterns: # is a number, * any text within the same
 * brackets, a blank one or more blanks; other characters may be preceded by blanks. */
#ifndef MUKCA_IO_PATTERN_H
#define MUKCA_IO_PATTERN_H

#include <stddef.h>

enum { MUKCA_PATTERN_NUMBERS = 24 };

typedef struct {
    int n;
    double value[MUKCA_PATTERN_NUMBERS];
    size_t span[MUKCA_PATTERN_NUMBERS][2]; /* the text of a number is line[span[0] .. span[1]) */
} mukca_pattern_numbers;

/* Match the pattern at line[at] and append its numbers; returns the end of the match, 0: no
 * match. */
size_t mukca_pattern_match(mukca_pattern_numbers *found, const char *pattern, const char *line,
                           size_t at);

/* Match a number at line[at]; returns its end, 0: no number. */
size_t mukca_pattern_number(double *value, const char *line, size_t at);

size_t mukca_pattern_skip_blanks(const char *line, size_t at);

#endif
