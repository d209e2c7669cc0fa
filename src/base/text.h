/* Text appended by printf in the caller's memory, truncated to its size. */
#ifndef MUKCA_BASE_TEXT_H
#define MUKCA_BASE_TEXT_H

#include <stddef.h>

typedef struct {
    char *at; /* [size], NUL-terminated after each put */
    size_t size, used;
} mukca_text;

/* Empty text in a char array. */
#define MUKCA_TEXT(array)                    \
    {                                        \
        .at = (array), .size = sizeof(array) \
    }

void mukca_text_put(mukca_text *text, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

#endif
