/* Memory pool: many blocks, freed at once. */
#include "base/pool.h"

#include <stdint.h>
#include <stdlib.h>

struct mukca_pool_block {
    mukca_pool_block *next;
    size_t used, size; /* bytes, this head included */
};

enum {
    LINE = 64, /* of the cache: a piece begins at one */
    LEAST = 4096,
    MOST = 64 * LEAST /* of a block that is shared */
};

/* Where a piece begins in a block, a line of the cache; 0: no room for it. */
static size_t room(const mukca_pool_block *block, size_t bytes)
{
    if (!block) return 0;
    const size_t at = block->used + (0 - ((size_t)block + block->used)) % LINE;
    return at <= block->size && bytes <= block->size - at ? at : 0;
}

/* A block with room for a piece.  A piece that needs much of a shared block has its own, behind the
 * first block, which has room for others. */
static mukca_pool_block *grow(mukca_pool *pool, size_t bytes)
{
    const size_t head = sizeof(mukca_pool_block) + LINE;
    mukca_pool_block *first = pool->blocks;
    size_t shared = first ? 4 * first->size : LEAST;
    if (shared > MOST) shared = MOST;
#ifdef __SANITIZE_ADDRESS__
    shared = 0; /* it finds accesses beyond a block */
#endif
    const bool own = bytes >= shared / 2;
    const size_t size = own ? head + bytes : shared;
    mukca_pool_block *block = calloc(1, size);
    if (!block) return NULL;
    *block = (mukca_pool_block){.used = sizeof *block, .size = size};
    if (own && first) {
        block->next = first->next;
        first->next = block;
    } else {
        block->next = first;
        pool->blocks = block;
    }
    return block;
}

void *mukca_pool_take(mukca_pool *pool, size_t count, size_t size)
{
    const size_t bytes = count * size;
    const bool fits = size == 0 || count <= (SIZE_MAX - MOST) / size;
    mukca_pool_block *block = pool->blocks;
    if (!room(block, bytes)) block = fits ? grow(pool, bytes) : NULL;
    if (!fits || !block) {
        pool->failed = true;
        return NULL;
    }
    const size_t at = room(block, bytes);
    block->used = at + bytes;
    return (char *)block + at;
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
