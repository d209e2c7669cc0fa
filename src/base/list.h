/* Lists that grow by one item at a time. */
#ifndef MUKCA_BASE_LIST_H
#define MUKCA_BASE_LIST_H

#include <stdlib.h>
#include <string.h>

/* Append a zeroed item of `size` bytes to the list of *n whose pointer is at `list`; it doubles at
 * each power of two.  Returns the item; NULL, and the list is unchanged: out of memory. */
static inline void *mukca_list_append(void *list, int *n, size_t size)
{
    char *items;
    memcpy(&items, list, sizeof items);
    char *grown = *n & (*n - 1) ? items : realloc(items, (*n ? 2 * (size_t)*n : 1) * size);
    if (!grown) return NULL;
    memcpy(list, &grown, sizeof grown);
    return memset(grown + size * (size_t)(*n)++, 0, size);
}

#endif
