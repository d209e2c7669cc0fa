/* Formatted text: appended, numbers, notes. */
#include "base/text.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/number.h"

void mukca_text_put(mukca_text *text, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    int n = vsnprintf(text->at + text->used, text->size - text->used, format, args);
    va_end(args);
    if (n > 0) text->used += (size_t)n;
    if (text->used >= text->size) text->used = text->size - 1;
}

bool mukca_text_item(char *item, size_t size, const char **list)
{
    if (!*list) return false;
    const size_t length = strcspn(*list, ",");
    snprintf(item, size, "%.*s", length < size ? (int)length : 0, *list);
    *list = (*list)[length] ? *list + length + 1 : NULL;
    return true;
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

void mukca_note_format(mukca_notes notes, const char *format, ...)
{
    char text[512];
    va_list args;
    if (!notes.write) return;
    va_start(args, format);
    const int length = vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (length >= (int)sizeof text) memcpy(text + sizeof text - 4, "...", 4);
    for (char *c = text; *c; c++)
        if (*c == '\n' || *c == '\t') *c = '?';
    mukca_utf8_mend(text);
    notes.write(notes.context, text);
}

/* ---- characters of UTF-8 (RFC 3629) ---- */

/* Whether a character is invisible: U+0080 to U+009F control terminals, as the codes below a blank
 * do; U+200B to U+200F, U+2028 to U+202E, U+2060 to U+206F are formats. */
static bool is_hidden(const unsigned char *c)
{
    return (*c < 0x20 && *c != '\t' && *c != '\n') || *c == 0x7F || (*c == 0xC2 && c[1] < 0xA0) ||
           (*c == 0xE2 && c[1] == 0x80 &&
            ((c[2] >= 0x8B && c[2] <= 0x8F) || (c[2] >= 0xA8 && c[2] <= 0xAE))) ||
           (*c == 0xE2 && c[1] == 0x81 && c[2] >= 0xA0 && c[2] <= 0xAF);
}

/* Bytes of the character at `text`; 0: invalid, or end of the text. */
static size_t letter(const char *text)
{
    const unsigned char *c = (const unsigned char *)text;
    const size_t n = *c == 0     ? 0
                     : *c < 0x80 ? 1
                     : *c < 0xC2 ? 0
                     : *c < 0xE0 ? 2
                     : *c < 0xF0 ? 3
                     : *c < 0xF5 ? 4
                                 : 0;
    for (size_t i = 1; i < n; i++)
        if ((c[i] & 0xC0) != 0x80) return 0;
    if ((*c == 0xE0 && c[1] < 0xA0) || (*c == 0xED && c[1] > 0x9F) || /* overlong; surrogates */
        (*c == 0xF0 && c[1] < 0x90) || (*c == 0xF4 && c[1] > 0x8F))
        return 0;
    return is_hidden(c) ? 0 : n;
}

size_t mukca_utf8_fit(const char *text, size_t most)
{
    size_t length = 0, n;
    while ((n = letter(text + length)) > 0 && length + n <= most) length += n;
    return length;
}

bool mukca_utf8_valid(const char *text)
{
    return text[mukca_utf8_fit(text, strlen(text))] == '\0';
}

void mukca_utf8_mend(char *text)
{
    while (*text) {
        const size_t n = letter(text);
        if (n == 0) *text = '?';
        text += n ? n : 1;
    }
}
