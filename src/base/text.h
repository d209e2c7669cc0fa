/* Text: appended by printf in the caller's memory, truncated to its size; notes; UTF-8. */
#ifndef MUKCA_BASE_TEXT_H
#define MUKCA_BASE_TEXT_H

#include <stdbool.h>
#include <stddef.h>

#include "mukca/status.h"

typedef struct {
    char *at; /* [size], NUL-terminated after each put */
    size_t size, used;
} mukca_text;

/* Empty text in a char array. */
#define MUKCA_TEXT(array)                    \
    {                                        \
        .at = (array), .size = sizeof(array) \
    }

void mukca_text_put(mukca_text *text, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Copy the next item of the comma-separated *list to item[size] and advance *list, which is NULL
 * after the last; false: *list is NULL.  An item that is too long becomes empty. */
bool mukca_text_item(char *item, size_t size, const char **list);

/* Receiver of notes; zeroed: none. */
typedef struct {
    mukca_note_fn *write;
    void *context;
} mukca_notes;

/* Write a printf-formatted note, truncated to 511 characters. */
void mukca_note_format(mukca_notes notes, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* ---- UTF-8, the only encoding of JSON and HTML, without characters that control a terminal or
 * change the order or the visibility of the others; tabs and line feeds are valid ---- */

/* Bytes of the longest prefix of `text` of complete, valid characters, at most `most`. */
size_t mukca_utf8_fit(const char *text, size_t most);

bool mukca_utf8_valid(const char *text);

/* Replace each byte that is not part of a valid character by '?'. */
void mukca_utf8_mend(char *text);

#endif
