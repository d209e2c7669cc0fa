/* The error record and notes. */
#include "mukca/status.h"

#include <stdarg.h>
#include <stdio.h>

#include "base/note.h"

mukca_status mukca_fail(mukca_error *error, mukca_status status, const char *format, ...)
{
    if (error) {
        va_list args;
        va_start(args, format);
        error->status = status;
        vsnprintf(error->text, sizeof error->text, format, args);
        va_end(args);
        /* names and cells of others stay in one line, without sequences that control a terminal */
        for (char *c = error->text; *c; c++)
            if ((unsigned char)*c < 0x20 || *c == 0x7f) *c = '?';
    }
    return status;
}

void mukca_note_format(mukca_note_fn *note, void *context, const char *format, ...)
{
    char text[256];
    va_list args;
    if (!note) return;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    note(context, text);
}
