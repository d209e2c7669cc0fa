/* Carve a caller's block of memory into aligned arrays; the same code counts and carves.
 *
 * A workspace routine is written once and run twice: with a NULL base it only counts the bytes that
 * it would need, with a block of that size it hands out the arrays:
 *
 *     static size_t carve(work *w, void *memory) {
 *         mukca_arena a = {.base = memory};
 *         w->x = MUKCA_CARVE(&a, double, n);
 *         return a.used;
 *     }
 */
#ifndef MUKCA_BASE_ARENA_H
#define MUKCA_BASE_ARENA_H

#include <stddef.h>

typedef struct {
    char *base;  /* NULL: count only */
    size_t used; /* bytes handed out (or counted) so far */
} mukca_arena;

/* Hand out `count` items of `size` bytes, aligned to 64; NULL while counting. */
static inline void *mukca_arena_take(mukca_arena *arena, size_t count, size_t size)
{
    size_t at = (arena->used + 63u) & ~(size_t)63u;
    arena->used = at + count * size;
    return arena->base ? arena->base + at : NULL;
}

#define MUKCA_CARVE(arena, type, count) \
    ((type *)mukca_arena_take((arena), (size_t)(count), sizeof(type)))

#endif
