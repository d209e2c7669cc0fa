/* Run-time dispatch of hot kernels: one binary, with vector instructions where available.
 *
 * A MUKCA_CLONES function is compiled for plain x86-64, for AVX2 (by feature: "arch=haswell" would
 * exclude AMD) and, with gcc 12 or later, for x86-64-v4, which broadcasts scalars from memory
 * within an instruction; the loader selects one (ifunc).  Without contraction or reassociation all
 * yield identical bits.  Without ifunc (musl, other processors), under sanitizers, or with
 * -DMUKCA_NO_CLONES it is a plain function.
 */
#ifndef MUKCA_BASE_CLONES_H
#define MUKCA_BASE_CLONES_H

#include <limits.h> /* defines __GLIBC__ */

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

/* Helpers of such a function: always inlined, to be compiled for the same processor. */
#define MUKCA_INLINE static inline __attribute__((always_inline))

#endif
