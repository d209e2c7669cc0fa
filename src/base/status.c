/* The error record and notes. */
#include "mukca/status.h"

#include <stdarg.h>
#include <stdio.h>

#include "base/note.h"
#include "base/utf8.h"

mukca_status mukca_fail(mukca_error *error, mukca_status status, const char *format, ...)
{
    if (error) {
        va_list args;
        va_start(args, format);
        error->status = status;
        vsnprintf(error->text, sizeof error->text, format, args);
        va_end(args);
        /* Foreign names and cells: keep to one line, remove control sequences of terminals, repair
         * a UTF-8 character cut by truncation. */
        for (char *c = error->text; *c; c++)
            if ((unsigned char)*c < 0x20 || *c == 0x7f) *c = '?';
        mukca_utf8_mend(error->text);
    }
    return status;
}

void mukca_note_format(mukca_note_fn *note, void *context, const char *format, ...)
{
    char text[512];
    va_list args;
    if (!note) return;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    mukca_utf8_mend(text);
    note(context, text);
}
