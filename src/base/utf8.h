/* Text that others can read: JSON and HTML hold UTF-8 only. */
#ifndef MUKCA_BASE_UTF8_H
#define MUKCA_BASE_UTF8_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Bytes of the longest beginning of `text` that is whole letters of UTF-8 and at most `most`. */
size_t mukca_utf8_fit(const char *text, size_t most);

bool mukca_utf8_valid(const char *text);

/* Put '?' in place of each byte that is no part of a letter. */
void mukca_utf8_mend(char *text);

#ifdef __cplusplus
}
#endif
#endif
