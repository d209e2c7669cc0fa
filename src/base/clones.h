/* Run-time dispatch of hot kernels: one binary, vector units used where the machine has them. */
#ifndef MUKCA_BASE_CLONES_H
#define MUKCA_BASE_CLONES_H

#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(MUKCA_NO_CLONES) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define MUKCA_CLONES __attribute__((target_clones("default", "arch=haswell")))
#else
#define MUKCA_CLONES
#endif

#endif
