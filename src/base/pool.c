/* Memory pool: many blocks, freed at once. */
#include "base/pool.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

struct mukca_pool_block {
    mukca_pool_block *next;
};

void *mukca_pool_take(mukca_pool *pool, size_t count, size_t size)
{
    const size_t head = 128; /* link and alignment */
    if (size != 0 && count > (SIZE_MAX - head) / size) {
        pool->failed = true;
        return NULL;
    }
    mukca_pool_block *block = calloc(1, head + count * size);
    if (!block) {
        pool->failed = true;
        return NULL;
    }
    block->next = pool->blocks;
    pool->blocks = block;
    const uintptr_t at = ((uintptr_t)block + sizeof *block + 63u) & ~(uintptr_t)63u;
    return (char *)block + (at - (uintptr_t)block);
}

void mukca_pool_free(mukca_pool *pool)
{
    while (pool->blocks) {
        mukca_pool_block *next = pool->blocks->next;
        free(pool->blocks);
        pool->blocks = next;
    }
    pool->failed = false;
}
