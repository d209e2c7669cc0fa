/* Memory pool: many blocks, freed at once. */
#include "base/pool.h"

#include <stdint.h>
#include <stdlib.h>

struct mukca_pool_block {
    mukca_pool_block *next;
    char *free;  /* rest of the block, */
    size_t left; /* bytes */
};

enum {
    LINE = 64, /* of the cache: a piece begins at one */
#ifdef __SANITIZE_ADDRESS__
    SHARED = 0 /* it finds accesses beyond a block */
#else
    SHARED = 1 << 16 /* bytes of a block for several pieces */
#endif
};

/* A block with room for a piece: the pool's first one, or behind it that of a large piece. */
static mukca_pool_block *grow(mukca_pool *pool, size_t bytes)
{
    const bool own = pool->blocks && bytes >= SHARED / 2;
    mukca_pool_block **at = own ? &pool->blocks->next : &pool->blocks;
    const size_t left = bytes < SHARED ? SHARED : bytes;
    mukca_pool_block *block = calloc(1, sizeof *block + LINE + left);
    if (!block) return NULL;
    char *start = (char *)(block + 1);
    *block = (mukca_pool_block){*at, start + (0 - (size_t)start) % LINE, left};
    *at = block;
    return block;
}

void *mukca_pool_take(mukca_pool *pool, size_t count, size_t size)
{
    const bool fits = size == 0 || count <= (SIZE_MAX - SHARED - 4 * LINE) / size;
    const size_t bytes = (count * size + LINE - 1) / LINE * LINE;
    mukca_pool_block *block = pool->blocks;
    if (fits && (!block || block->left < bytes)) block = grow(pool, bytes);
    if (!fits || !block) {
        pool->failed = true;
        return NULL;
    }
    void *piece = block->free;
    block->free += bytes;
    block->left -= bytes;
    return piece;
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
