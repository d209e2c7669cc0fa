/* Text that grows by printf in the caller's memory; what does not fit is cut off. */
#ifndef MUKCA_BASE_TEXT_H
#define MUKCA_BASE_TEXT_H

#include <stddef.h>

typedef struct {
    char *at; /* [size], ends with a NUL after each put */
    size_t size, used;
} mukca_text;

/* An empty one on a char array. */
#define MUKCA_TEXT(array)                    \
    {                                        \
        .at = (array), .size = sizeof(array) \
    }

void mukca_text_put(mukca_text *text, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

#endif
