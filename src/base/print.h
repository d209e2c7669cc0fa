/* Text from a format without stdio, for what runs on controllers.  The conversions are %s, %.Ns,
 * %.*s, %d, %+d, %.Ng (N of 1 to 15) and %%; others are printed as they stand. */
#ifndef MUKCA_BASE_PRINT_H
#define MUKCA_BASE_PRINT_H

#include <stdarg.h>
#include <stddef.h>

/* Write to text[size], size > 0; what does not fit is cut off.  Always ends with a NUL. */
void mukca_print(char *text, size_t size, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

void mukca_print_list(char *text, size_t size, const char *format, va_list args)
    __attribute__((format(printf, 3, 0)));

#endif
