/* The clocks of the program. */
#ifndef MUKCA_BASE_CLOCK_H
#define MUKCA_BASE_CLOCK_H

#include <stdint.h>
#include <time.h>

/* s, monotonic. */
static inline double mukca_clock_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* us since 1970, wall clock. */
static inline int64_t mukca_clock_wall(void)
{
    struct timespec t;
    clock_gettime(CLOCK_REALTIME, &t);
    return (int64_t)t.tv_sec * 1000000 + t.tv_nsec / 1000;
}

#endif
