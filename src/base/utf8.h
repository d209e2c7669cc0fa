/* Validation and repair of UTF-8, the only encoding of JSON and HTML. */
#ifndef MUKCA_BASE_UTF8_H
#define MUKCA_BASE_UTF8_H

#include <stdbool.h>
#include <stddef.h>

/* Bytes of the longest prefix of `text` of complete UTF-8 characters, at most `most`. */
size_t mukca_utf8_fit(const char *text, size_t most);

bool mukca_utf8_valid(const char *text);

/* Replace each byte that is not part of a valid character by '?'. */
void mukca_utf8_mend(char *text);

#endif
