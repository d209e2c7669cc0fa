/* A whole file as bytes in memory. */
#include "io/file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/table.h"

static mukca_status read_stream(char **text, size_t *length, FILE *stream, size_t most)
{
    size_t capacity = 0;
    do {
        if (capacity - *length < 2) {
            capacity = capacity ? 2 * capacity : 1 << 14;
            char *grown = realloc(*text, capacity);
            if (!grown) return MUKCA_MEMORY;
            *text = grown;
        }
        *length += fread(*text + *length, 1, capacity - *length - 1, stream);
        (*text)[*length] = '\0';
        if (*length > most || ferror(stream)) return MUKCA_INPUT;
    } while (!feof(stream));
    return MUKCA_OK;
}

mukca_status mukca_file_read(char **text, size_t *length, const char *path, size_t most,
                             mukca_error *error)
{
    *text = NULL;
    *length = 0;
    errno = 0;
    FILE *stream = fopen(path, "rb");
    const mukca_status status = stream ? read_stream(text, length, stream, most) : MUKCA_INPUT;
    const int reason = errno;
    const bool large = *length > most;
    if (stream) fclose(stream);
    if (status == MUKCA_OK) return MUKCA_OK;
    free(*text);
    *text = NULL;
    if (status == MUKCA_MEMORY) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    path = mukca_table_short_path(path);
    if (large)
        return mukca_fail(error, MUKCA_INPUT, "%s: is larger than %zu MiB", path, most >> 20);
    return mukca_fail(error, MUKCA_INPUT, "%s: cannot read: %s", path, strerror(reason));
}
