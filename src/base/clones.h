/* Run-time dispatch of hot kernels: one binary, vector units used where the machine has them.
 *
 * A MUKCA_CLONES function is compiled for plain x86-64, for AVX2 (by feature: "arch=haswell" would
 * leave out AMD) and, by gcc 12 or later, for x86-64-v4, whose vectors take factors from memory as
 * they are, and the loader picks one (ifunc).  Nothing is contracted or reassociated, so all give
 * the same bits.  Where there is no ifunc (musl, other processors),
 * under sanitizers, or with -DMUKCA_NO_CLONES it is the plain function.
 */
#ifndef MUKCA_BASE_CLONES_H
#define MUKCA_BASE_CLONES_H

#include <limits.h> /* lets glibc say that it is glibc */

#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(MUKCA_NO_CLONES)
#if __GNUC__ >= 12
#define MUKCA_CLONES __attribute__((target_clones("default", "avx2", "arch=x86-64-v4")))
#else
#define MUKCA_CLONES __attribute__((target_clones("default", "avx2")))
#endif
#else
#define MUKCA_CLONES
#endif

/* Helpers of such a function: always inlined, so that they are compiled for its processor. */
#define MUKCA_INLINE static inline __attribute__((always_inline))

#endif
