/* The error record and notes. */
#include "mukca/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/note.h"
#include "base/utf8.h"

/* End a truncated text in "...". */
static void mark_cut(char *text, size_t size)
{
    text[size - 4] = '\0';
    mukca_utf8_mend(text); /* the last character may be cut */
    memcpy(text + strlen(text), "...", 4);
}

mukca_status mukca_fail(mukca_error *error, mukca_status status, const char *format, ...)
{
    if (error) {
        va_list args;
        va_start(args, format);
        error->status = status;
        const int length = vsnprintf(error->text, sizeof error->text, format, args);
        va_end(args);
        if (length >= (int)sizeof error->text) mark_cut(error->text, sizeof error->text);
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
    if (vsnprintf(text, sizeof text, format, args) >= (int)sizeof text) mark_cut(text, sizeof text);
    va_end(args);
    mukca_utf8_mend(text);
    note(context, text);
}
