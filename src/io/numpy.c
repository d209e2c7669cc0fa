/* Arrays of numpy as text. */
#include "io/numpy.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

enum { MOST_COLUMNS = 4096 };

bool mukca_numpy_is_array(FILE *stream)
{
    const int first = getc(stream);
    if (first != EOF) ungetc(first, stream);
    return first == 0x93;
}

typedef struct {
    int size; /* bytes of a number: 4 or 8 */
    long rows, columns;
} array_shape;

/* Parse the header of an array, such as {'descr': '<f8', 'fortran_order': False, 'shape': (9, 6)}.
 */
static bool read_shape(array_shape *a, FILE *stream)
{
    unsigned char start[12];
    char text[1024];
    if (fread(start, 1, 10, stream) != 10 || memcmp(start, "\x93NUMPY", 6) != 0) return false;
    size_t length = start[8] + 256u * start[9];
    if (start[6] > 1 && (fread(start + 10, 1, 2, stream) != 2 || start[10] || start[11]))
        return false;
    if (length >= sizeof text || fread(text, 1, length, stream) != length) return false;
    text[length] = '\0';
    const char *shape = strstr(text, "'shape': (");
    a->size = strstr(text, "'descr': '<f8'") ? 8 : strstr(text, "'descr': '<f4'") ? 4 : 0;
    if (!shape || !a->size || !strstr(text, "'fortran_order': False")) return false;
    char *end;
    a->rows = strtol(shape + strlen("'shape': ("), &end, 10);
    a->columns = 1;
    for (const char *at = end; *at == ','; at = end) {
        const long n = strtol(at + 1, &end, 10);
        if (end == at + 1) break; /* (9,) */
        if (n < 1 || n > MOST_COLUMNS) return false;
        a->columns *= n;
        if (a->columns > MOST_COLUMNS) return false;
    }
    return a->rows >= 0;
}

static bool read_number(double *value, int size, FILE *stream)
{
    unsigned char bytes[8];
    uint64_t bits = 0;
    if (fread(bytes, 1, (size_t)size, stream) != (size_t)size) return false;
    for (int i = size; i-- > 0;) bits = bits << 8 | bytes[i];
    const uint32_t few = (uint32_t)bits;
    float single;
    if (size == 8) memcpy(value, &bits, sizeof *value);
    if (size == 4) memcpy(&single, &few, sizeof single), *value = (double)single;
    return true;
}

mukca_status mukca_numpy_read(FILE **stream, const char *path, mukca_error *error)
{
    array_shape a;
    if (!read_shape(&a, *stream))
        return mukca_fail(error, MUKCA_INPUT,
                          "%s: an array of numpy of another kind; save one of numbers: "
                          "numpy.save(FILE, numpy.ascontiguousarray(a, float))",
                          mukca_file_shown(path));
    FILE *text = tmpfile();
    if (!text) return mukca_file_fail(error, path);
    bool whole = true;
    for (long i = 0; i < a.rows && whole && !ferror(text); i++)
        for (long c = 0; c < a.columns && whole; c++) {
            double value = 0;
            whole = read_number(&value, a.size, *stream);
            fprintf(text, "%.17g%c", value, c + 1 < a.columns ? ',' : '\n');
        }
    if (!whole || fflush(text) || fseek(text, 0, SEEK_SET)) {
        fclose(text);
        return whole ? mukca_file_fail(error, path)
                     : mukca_fail(error, MUKCA_INPUT, "%s: the array is cut off",
                                  mukca_file_shown(path));
    }
    if (*stream != stdin) fclose(*stream);
    *stream = text;
    return MUKCA_OK;
}
