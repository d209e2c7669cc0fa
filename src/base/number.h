/* Numbers and text without stdio and locale, for code on controllers too. */
#ifndef MUKCA_BASE_NUMBER_H
#define MUKCA_BASE_NUMBER_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

/* Upper bound of lengths (m), masses (kg) and coefficients of any arm; results computed from
 * smaller numbers are finite. */
#define MUKCA_NUMBER_LARGEST 1e6

/* True if all of `text` is one finite decimal number ("-1.5e-3"); not for hexadecimal, nan, inf,
 * spaces and decimal commas.  Rounded to nearest even; of more than 19 digits, and below 2.3e-308,
 * to a neighbour of it at most. */
bool mukca_number_parse(double *value, const char *text);

/* Exactly n numbers separated by spaces, tabs or newlines, as in `xyz="0 0 1"`. */
bool mukca_number_parse_list(double *values, int n, const char *text);

/* The shortest of %.15g, %.16g and %.17g that reads back as the same double; 0 has no sign. */
enum { MUKCA_NUMBER_SIZE = 32 };
void mukca_number_format(char text[MUKCA_NUMBER_SIZE], double value);

/* Formatted text (print.c).  The conversions are %s, %.Ns, %.*s, %d, %+d, %.Ng (N from 1 to 15) and
 * %%; others are copied verbatim.  Write to text[size], size > 0; truncated, always NUL-terminated.
 */
void mukca_print(char *text, size_t size, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

void mukca_print_list(char *text, size_t size, const char *format, va_list args)
    __attribute__((format(printf, 3, 0)));

#endif
