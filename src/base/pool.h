/* Memory pool: allocate zeroed blocks, check once, free once. */
#ifndef MUKCA_BASE_POOL_H
#define MUKCA_BASE_POOL_H

#include <stdbool.h>
#include <stddef.h>

typedef struct mukca_pool_block mukca_pool_block;

typedef struct {
    mukca_pool_block *blocks;
    bool failed; /* sticky: an allocation has failed */
} mukca_pool;

/* Zeroed memory for `count` items of `size` bytes, aligned to 64; NULL (and `failed`) if out of
 * memory. */
void *mukca_pool_take(mukca_pool *pool, size_t count, size_t size);

/* Free all blocks; the pool is empty and reusable afterwards. */
void mukca_pool_free(mukca_pool *pool);

#define MUKCA_TAKE(pool, type, count) mukca_pool_take((pool), (size_t)(count), sizeof(type))

#endif
