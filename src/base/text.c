/* Formatted text: appended, numbers, notes. */
#include "base/text.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/note.h"
#include "base/number.h"
#include "base/utf8.h"

void mukca_text_put(mukca_text *text, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    int n = vsnprintf(text->at + text->used, text->size - text->used, format, args);
    va_end(args);
    if (n > 0) text->used += (size_t)n;
    if (text->used >= text->size) text->used = text->size - 1;
}

/* ---- numbers ---- */

void mukca_number_format(char text[MUKCA_NUMBER_SIZE], double value)
{
    for (int digits = 15; digits <= 17; digits++) {
        double back;
        snprintf(text, MUKCA_NUMBER_SIZE, "%.*g", digits, value + 0.0); /* -0 + 0 is 0 */
        if (mukca_number_parse(&back, text) && !(back < value) && !(back > value)) return;
    }
}

/* ---- notes ---- */

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
