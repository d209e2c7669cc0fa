/* Kernels compiled for each width of the registers: sums stay in them. */
#ifndef MUKCA_BASE_KERNEL_H
#define MUKCA_BASE_KERNEL_H

#include "base/clones.h"

/* Two doubles, which every processor with vectors of them has in a register, and eight.  Vectors
 * wider than a register (`four` without AVX2) are in memory.  Unaligned. */
typedef double pair __attribute__((vector_size(16), aligned(8), may_alias));
typedef double eight __attribute__((vector_size(64), aligned(8), may_alias));

/* MUKCA_KERNEL(linkage, name, (parameters), arguments): name_any(parameters, width) is compiled for
 * registers of eight, four and two doubles (gcc 12 or later on x86-64, else two); name() selects.
 */
#define MUKCA_KERNEL_OF(width, name, parameters, ...) \
    static void name##_##width parameters             \
    {                                                 \
        name##_any(__VA_ARGS__, width);               \
    }
#define MUKCA_KERNEL_4(name, parameters, ...) \
    __attribute__((target("arch=x86-64-v3"))) MUKCA_KERNEL_OF(4, name, parameters, __VA_ARGS__)
#define MUKCA_KERNEL_8(name, parameters, ...) \
    __attribute__((target("arch=x86-64-v4"))) MUKCA_KERNEL_OF(8, name, parameters, __VA_ARGS__)
#ifdef MUKCA_CLONES_V4
#define MUKCA_KERNEL(linkage, name, parameters, ...)                     \
    MUKCA_KERNEL_8(name, parameters, __VA_ARGS__)                        \
    MUKCA_KERNEL_4(name, parameters, __VA_ARGS__)                        \
    MUKCA_KERNEL_OF(2, name, parameters, __VA_ARGS__)                    \
    linkage void name parameters                                         \
    {                                                                    \
        (__builtin_cpu_supports("x86-64-v4")   ? name##_8                \
         : __builtin_cpu_supports("x86-64-v3") ? name##_4                \
                                               : name##_2)(__VA_ARGS__); \
    }
#else
#define MUKCA_KERNEL(linkage, name, parameters, ...) \
    linkage void name parameters                     \
    {                                                \
        name##_any(__VA_ARGS__, 2);                  \
    }
#endif

#endif
