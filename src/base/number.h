/* Numbers from text and as text: decimal, finite, a point as in the C locale. */
#ifndef MUKCA_BASE_NUMBER_H
#define MUKCA_BASE_NUMBER_H

#include <stdbool.h>

/* No arm has a length (m), a mass (kg) or an effect's coefficient beyond it; what is computed from
 * numbers below it is finite. */
#define MUKCA_NUMBER_LARGEST 1e6

/* True where all of `text` is one finite decimal number ("-1.5e-3"); hexadecimal, nan, inf, spaces
 * and decimal commas are none. */
bool mukca_number_parse(double *value, const char *text);

/* Exactly n numbers parted by spaces, tabs or newlines, as in `xyz="0 0 1"`. */
bool mukca_number_parse_list(double *values, int n, const char *text);

/* The shortest of %.15g, %.16g and %.17g that reads back as the same double; 0 has no sign. */
enum { MUKCA_NUMBER_SIZE = 32 };
void mukca_number_format(char text[MUKCA_NUMBER_SIZE], double value);

#endif
