/* Seeded random numbers: the same stream on every machine (xoshiro256++ seeded by splitmix64). */
#ifndef MUKCA_MATH_RANDOM_H
#define MUKCA_MATH_RANDOM_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint64_t state[4];
    double spare; /* second normal variate of the polar method */
    bool has_spare;
} mukca_random;

mukca_random mukca_random_seeded(uint64_t seed);
uint64_t mukca_random_bits(mukca_random *random);
double mukca_random_uniform(mukca_random *random);   /* [0, 1) */
double mukca_random_normal(mukca_random *random);    /* mean 0, sigma 1 */
int mukca_random_below(mukca_random *random, int n); /* 0 .. n-1, unbiased */

#endif
