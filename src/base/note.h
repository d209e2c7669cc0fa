/* Formatted notes. */
#ifndef MUKCA_BASE_NOTE_H
#define MUKCA_BASE_NOTE_H

#include "mukca/status.h"

/* Call `note` (may be NULL) with a printf-formatted line, truncated to 511 characters. */
void mukca_note_format(mukca_note_fn *note, void *context, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
