/* The clocks of the program. */
#ifndef MUKCA_BASE_CLOCK_H
#define MUKCA_BASE_CLOCK_H

#include <stdint.h>

/* s; never set back. */
double mukca_clock_seconds(void);

/* us since 1970. */
int64_t mukca_clock_wall(void);

#endif
