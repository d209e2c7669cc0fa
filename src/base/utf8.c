/* Characters of UTF-8 (RFC 3629). */
#include "base/utf8.h"

#include <string.h>

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
    return n;
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
