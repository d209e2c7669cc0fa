/* Lanes of doubles, as portable vectors of the compiler. */
#ifndef MUKCA_MATH_FOUR_H
#define MUKCA_MATH_FOUR_H

#include <stdint.h>
#include <string.h>

#include "base/clones.h"

#if MUKCA_LANES == 4
typedef four lanes;
typedef int64_t lane_bits __attribute__((vector_size(32), aligned(8), may_alias));
#define LANE_BITS(x) ((lane_bits)(x))
#define BITS_LANES(b) ((lanes)(b))
#define NOT_WITHIN(x, limit) (~((x) <= (limit)))
#define ANY_LANE(b) ((b)[0] | (b)[1] | (b)[2] | (b)[3])
#else
typedef double lanes;
typedef int64_t lane_bits;
static inline lane_bits LANE_BITS(lanes x)
{
    lane_bits b;
    memcpy(&b, &x, sizeof b);
    return b;
}
static inline lanes BITS_LANES(lane_bits b)
{
    lanes x;
    memcpy(&x, &b, sizeof x);
    return x;
}
#define NOT_WITHIN(x, limit) (-(lane_bits) !((x) <= (limit)))
#define ANY_LANE(b) (b)
#endif
#define LOAD_LANES(x) (*(const lanes *)(const void *)(x))
#define STORE_LANES(x, value) (*(lanes *)(void *)(x) = (value))

MUKCA_INLINE double dot4(const double *x, const double *y, int n)
{
    four s = {0};
    int n4 = n & ~3;
    for (int i = 0; i < n4; i += 4) s += LOAD4(x + i) * LOAD4(y + i);
    double sum = (s[0] + s[1]) + (s[2] + s[3]);
    for (int i = n4; i < n; i++) sum += x[i] * y[i];
    return sum;
}

#endif
