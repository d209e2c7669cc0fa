/* Numbers in lines of robot programs, found by patterns. */
#include "io/pattern.h"

#include <ctype.h>
#include <stdbool.h>
#include <string.h>

#include "base/number.h"

size_t mukca_pattern_number(double *value, const char *line, size_t at)
{
    char text[64];
    const size_t length = strspn(line + at, "+-0123456789.eE");
    if (length == 0 || length >= sizeof text) return 0;
    const bool plus = line[at] == '+';
    memcpy(text, line + at + plus, length - plus);
    text[length - plus] = '\0';
    return mukca_number_parse(value, text) ? at + length : 0;
}

size_t mukca_pattern_skip_blanks(const char *line, size_t at)
{
    while (isblank((unsigned char)line[at])) at++;
    return at;
}

size_t mukca_pattern_match(mukca_pattern_numbers *found, const char *pattern, const char *line,
                           size_t at)
{
    for (const char *p = pattern; *p; p++) {
        if (*p == ' ') {
            if (!isblank((unsigned char)line[at])) return 0;
            continue;
        }
        if (*p == '*') { /* up to the first position from which the rest matches */
            const mukca_pattern_numbers so_far = *found;
            for (;; at++) {
                const size_t end = mukca_pattern_match(found, p + 1, line, at);
                if (end) return end;
                *found = so_far;
                if (!line[at] || strchr("{}[]", line[at])) return 0;
            }
        }
        const bool in_word =
            p > pattern && isalnum((unsigned char)*p) && isalnum((unsigned char)p[-1]);
        if (!in_word) at = mukca_pattern_skip_blanks(line, at);
        if (*p == '#') {
            const size_t end = found->n < MUKCA_PATTERN_NUMBERS
                                   ? mukca_pattern_number(&found->value[found->n], line, at)
                                   : 0;
            if (end == 0) return 0;
            found->span[found->n][0] = at;
            found->span[found->n++][1] = at = end;
        } else if (line[at++] != *p) {
            return 0;
        }
    }
    return at;
}
