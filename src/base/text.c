/* Text appended by printf in the caller's memory. */
#include "base/text.h"

#include <stdarg.h>
#include <stdio.h>

void mukca_text_put(mukca_text *text, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    int n = vsnprintf(text->at + text->used, text->size - text->used, format, args);
    va_end(args);
    if (n > 0) text->used += (size_t)n;
    if (text->used >= text->size) text->used = text->size - 1;
}
