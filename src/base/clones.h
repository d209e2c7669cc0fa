/* Run-time dispatch of hot kernels: one binary, vector units used where the machine has them.
 *
 * A MUKCA_CLONES function is compiled twice, for plain x86-64 and for AVX2 (by feature:
 * "arch=haswell" would leave out AMD), and the loader picks one (ifunc).  Nothing is contracted or
 * reassociated, so both give the same bits.  Where there is no ifunc (musl, other processors),
 * under sanitizers, or with -DMUKCA_NO_CLONES it is the plain function.
 */
#ifndef MUKCA_BASE_CLONES_H
#define MUKCA_BASE_CLONES_H

#include <limits.h> /* lets glibc say that it is glibc */

#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(MUKCA_NO_CLONES)
#define MUKCA_CLONES __attribute__((target_clones("default", "avx2")))
#else
#define MUKCA_CLONES
#endif

/* Helpers of such a function: always inlined, so that they are compiled for its processor. */
#define MUKCA_INLINE static inline __attribute__((always_inline))

#endif
