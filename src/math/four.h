/* Four doubles at a time in the compiler's portable vectors, and runtime dispatch for those who do.
 *
 * A MUKCA_CLONES function is compiled twice, for plain x86-64 and for AVX2 (by feature:
 * "arch=haswell" would leave out AMD), and the loader picks one (ifunc).  Nothing is contracted or
 * reassociated, so both give the same bits.  Where there is no ifunc (musl, other processors),
 * under sanitizers, or with -DMUKCA_NO_CLONES it is the plain function.
 */
#ifndef MUKCA_MATH_FOUR_H
#define MUKCA_MATH_FOUR_H

#include <limits.h> /* lets glibc say that it is glibc */

#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(MUKCA_NO_CLONES)
#define MUKCA_CLONES __attribute__((target_clones("default", "avx2")))
#else
#define MUKCA_CLONES
#endif

/* Helpers of such a function: always inlined, so that they are compiled for its processor. */
#define MUKCA_INLINE static inline __attribute__((always_inline))

/* Unaligned; the compiler splits it where the processor has no such register. */
typedef double four __attribute__((vector_size(32), aligned(8), may_alias));

/* A macro: a function that returns a wide vector has no fixed calling convention. */
#define LOAD4(x) (*(const four *)(const void *)(x))

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
