/* The clocks of the program. */
#ifndef MUKCA_BASE_CLOCK_H
#define MUKCA_BASE_CLOCK_H

#include <stdint.h>

/* s, monotonic. */
double mukca_clock_seconds(void);

/* us since 1970, wall clock. */
int64_t mukca_clock_wall(void);

#endif
