/* The error record. */
#include "mukca/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

mukca_status mukca_fail(mukca_error *error, mukca_status status, const char *format, ...)
{
    if (error) {
        va_list args;
        va_start(args, format);
        error->status = status;
        const int length = vsnprintf(error->text, sizeof error->text, format, args);
        va_end(args);
        if (length >= (int)sizeof error->text) /* cut: say so */
            memcpy(error->text + sizeof error->text - 4, "...", 4);
        /* Foreign names and cells: keep to one line, remove control sequences of terminals. */
        for (char *c = error->text; *c; c++)
            if ((unsigned char)*c < 0x20 || *c == 0x7f) *c = '?';
    }
    return status;
}
