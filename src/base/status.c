/* The error record. */
#include "mukca/status.h"

#include <stdarg.h>
#include <stdio.h>

mukca_status mukca_fail(mukca_error *error, mukca_status status, const char *format, ...)
{
    if (error) {
        va_list args;
        va_start(args, format);
        error->status = status;
        vsnprintf(error->text, sizeof error->text, format, args);
        va_end(args);
        /* Foreign names and cells: keep to one line, remove control sequences of terminals. */
        for (char *c = error->text; *c; c++)
            if ((unsigned char)*c < 0x20 || *c == 0x7f) *c = '?';
    }
    return status;
}
