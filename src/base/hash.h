/* FNV-1a, 64 bits (Fowler, Noll, Vo): detects changes that are accidents, not attacks. */
#ifndef MUKCA_BASE_HASH_H
#define MUKCA_BASE_HASH_H

#include <stddef.h>
#include <stdint.h>

#define MUKCA_HASH_START UINT64_C(14695981039346656037)

/* Continue `hash` (at first MUKCA_HASH_START) with n bytes. */
static inline uint64_t mukca_hash(uint64_t hash, const void *bytes, size_t n)
{
    const unsigned char *b = bytes;
    for (size_t i = 0; i < n; i++) hash = (hash ^ b[i]) * UINT64_C(1099511628211);
    return hash;
}

#endif
