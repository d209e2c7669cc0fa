/* Run-time dispatch of hot kernels: one binary, with vector instructions where available.
 *
 * A MUKCA_CLONES function is compiled for plain x86-64, for AVX2 (by feature: "arch=haswell" would
 * exclude AMD) and, with gcc 12 or later, for x86-64-v4, which broadcasts scalars from memory
 * within an instruction; the loader selects one (ifunc).  All yield identical bits, but the dense
 * products, which the Makefile compiles with contraction, differ by rounding.  Without ifunc (musl,
 * other processors), under sanitizers, or with -DMUKCA_NO_CLONES it is a plain function. */
#ifndef MUKCA_BASE_CLONES_H
#define MUKCA_BASE_CLONES_H

#include <limits.h> /* defines __GLIBC__ */

#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(MUKCA_NO_CLONES)
#if __GNUC__ >= 12
#define MUKCA_CLONES_V4
#define MUKCA_CLONES __attribute__((target_clones("default", "avx2", "arch=x86-64-v4")))
#else
#define MUKCA_CLONES __attribute__((target_clones("default", "avx2")))
#endif
#else
#define MUKCA_CLONES
#endif

/* Helpers of such a function: always inlined, to be compiled for the same processor. */
#define MUKCA_INLINE static inline __attribute__((always_inline))

/* Four doubles.  Unaligned; on processors without such registers the compiler splits it. */
typedef double four __attribute__((vector_size(32), aligned(8), may_alias));
/* Macros: functions that return wide vectors have no fixed calling convention. */
#define LOAD4(x) (*(const four *)(const void *)(x))
#define STORE4(x, value) (*(four *)(void *)(x) = (value))

/* Lanes of the kernels shared with controllers: four on processors with vectors of doubles, else
 * one, which every compiler translates efficiently.  Results are bit-identical. */
#if (defined(__x86_64__) || defined(__aarch64__)) && !defined(MUKCA_SCALAR)
#define MUKCA_LANES 4
#else
#define MUKCA_LANES 1
#endif
/* Alignment of members that contain lanes: access across two cache lines is slower. */
#define LANES_ALIGNED _Alignas(8 * MUKCA_LANES)

#endif
