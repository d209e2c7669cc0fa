/* Four doubles at a time in the compiler's portable vectors. */
#ifndef MUKCA_MATH_FOUR_H
#define MUKCA_MATH_FOUR_H

#include "base/clones.h"

/* Unaligned; the compiler splits it where the processor has no such register. */
typedef double four __attribute__((vector_size(32), aligned(8), may_alias));

/* Macros: a function that returns a wide vector has no fixed calling convention. */
#define LOAD4(x) (*(const four *)(const void *)(x))
#define STORE4(x, value) (*(four *)(void *)(x) = (value))

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
