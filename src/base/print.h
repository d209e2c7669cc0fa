/* Formatted text without stdio, for code on controllers.  The conversions are %s, %.Ns, %.*s, %d,
 * %+d, %.Ng (N from 1 to 15) and %%; others are copied verbatim. */
#ifndef MUKCA_BASE_PRINT_H
#define MUKCA_BASE_PRINT_H

#include <stdarg.h>
#include <stddef.h>

/* Write to text[size], size > 0; truncated, always NUL-terminated. */
void mukca_print(char *text, size_t size, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

void mukca_print_list(char *text, size_t size, const char *format, va_list args)
    __attribute__((format(printf, 3, 0)));

#endif
