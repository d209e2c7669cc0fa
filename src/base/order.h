/* Comparisons for qsort(). */
#ifndef MUKCA_BASE_ORDER_H
#define MUKCA_BASE_ORDER_H

/* Define static int name(), which orders items of a type by a falling number in them. */
#define MUKCA_FALLING(name, type, number)                                          \
    static int name(const void *a, const void *b)                                  \
    {                                                                              \
        const double x = ((const type *)a)->number, y = ((const type *)b)->number; \
        return (x < y) - (x > y);                                                  \
    }

#endif
