/* Reading of whole text files, checked close of streams. */
#include "base/file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Far above the size of any URDF, table or type description. */
enum { FIRST = 1 << 14, LARGEST = 1 << 25 };

const char *mukca_file_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

const char *mukca_file_shown(const char *path)
{
    const size_t length = strlen(path);
    return length > 100 ? path + length - 100 : path;
}

mukca_status mukca_file_fail(mukca_error *error, const char *path)
{
    return mukca_fail(error, errno == ENOMEM ? MUKCA_MEMORY : MUKCA_INPUT, "%s: cannot read: %s",
                      mukca_file_shown(path), strerror(errno));
}

bool mukca_file_close(FILE *stream, char *const *text)
{
    if (!stream) return false;
    const bool good = !ferror(stream);
    return fclose(stream) == 0 && good && (!text || *text);
}

static mukca_status read_stream(char **text, FILE *stream, const char *path, mukca_error *error)
{
    size_t capacity = 0, length = 0;
    while (length == capacity && length <= LARGEST) {
        capacity = capacity ? 2 * capacity : FIRST;
        char *grown = realloc(*text, capacity + 1);
        if (!grown) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
        *text = grown;
        length += fread(grown + length, 1, capacity - length, stream);
        grown[length] = '\0';
    }
    if (ferror(stream)) return mukca_file_fail(error, path);
    if (length > LARGEST)
        return mukca_fail(error, MUKCA_INPUT, "%s: is larger than %d MiB", mukca_file_shown(path),
                          LARGEST >> 20);
    if (strlen(*text) == length) return MUKCA_OK;
    return mukca_fail(error, MUKCA_INPUT, "%s: contains a zero byte; save it as UTF-8 text",
                      mukca_file_shown(path));
}

mukca_status mukca_file_read(char **text, const char *path, mukca_error *error)
{
    FILE *stream = strcmp(path, "-") == 0 ? stdin : fopen(path, "rb");
    *text = NULL;
    if (!stream) return mukca_file_fail(error, path);
    const mukca_status status = read_stream(text, stream, path, error);
    if (stream != stdin) fclose(stream);
    if (status != MUKCA_OK) free(*text), *text = NULL;
    return status;
}
