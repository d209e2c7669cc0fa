/* Formatted notes. */
#include "base/note.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/utf8.h"

void mukca_note_format(mukca_note_fn *note, void *context, const char *format, ...)
{
    char text[512];
    va_list args;
    if (!note) return;
    va_start(args, format);
    const int length = vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (length >= (int)sizeof text) memcpy(text + sizeof text - 4, "...", 4);
    mukca_utf8_mend(text);
    note(context, text);
}
