/* Text tables, read row by row. */
#include "io/table.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/cells.h"
#include "base/file.h"
#include "base/number.h"

/* Bytes: a header has some ten lines of comments. */
enum { COMMENTS = 4096, READ_TOGETHER = 1 << 16 };

void mukca_table_fail(mukca_table *t, int column, const char *format, ...)
{
    char text[256], where[96] = "";
    mukca_text place = MUKCA_TEXT(where);
    va_list args;
    if (t->status != MUKCA_OK) return;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (column != MUKCA_WHOLE_TABLE) mukca_text_put(&place, "%d:", t->line);
    if (column >= 0 && t->header)
        mukca_text_put(&place, " column '%.40s':", t->header[column]);
    else if (column >= 0)
        mukca_text_put(&place, " column %d:", column + 1);
    t->status =
        mukca_fail(t->error, MUKCA_INPUT, "%s:%s %s", mukca_file_shown(t->path), where, text);
}

void mukca_table_stop(mukca_table *t, mukca_status status)
{
    if (t->status == MUKCA_OK) t->status = status;
}

/* Zeroed memory; NULL is a failure. */
static void *take(mukca_table *t, size_t count, size_t size)
{
    void *memory = mukca_pool_take(&t->pool, count, size);
    if (!memory && t->status == MUKCA_OK)
        t->status = mukca_fail(t->error, MUKCA_MEMORY, "out of memory while reading a table");
    return memory;
}

/* Read one line without its end into table->buffer; false at the end of the file. */
static bool read_line(mukca_table *t)
{
    char *line = t->buffer;
    if (!line || t->status != MUKCA_OK) return false;
    errno = 0;
    const bool more = fgets(line, MUKCA_TABLE_LINE, t->stream) != NULL;
    if (ferror(t->stream)) mukca_table_stop(t, mukca_file_fail(t->error, t->path));
    if (!more) return false;
    size_t length = strlen(line);
    t->line++;
    t->cut_off = feof(t->stream) != 0;
    if (length == MUKCA_TABLE_LINE - 1 && line[length - 1] != '\n')
        mukca_table_fail(t, -1, "the line is longer than 1 MiB; this is no table");
    else if (length == 0 || (!t->cut_off && line[length - 1] != '\n'))
        mukca_table_fail(t, -1, "contains a zero byte; this is not a text file");
    while (length && (line[length - 1] == '\n' || line[length - 1] == '\r')) line[--length] = '\0';
    if (strchr(line, '\r'))
        mukca_table_fail(t, -1, "lines end in carriage returns; save it with line feeds");
    if (t->line == 1 && strncmp(line, "\xEF\xBB\xBF", 3) == 0) memmove(line, line + 3, length - 2);
    return t->status == MUKCA_OK;
}

/* Read the next line that is neither blank nor a comment; false at the end of the file. */
static bool read_content(mukca_table *t)
{
    while (read_line(t)) {
        const char *text = t->buffer + strspn(t->buffer, " \t\r");
        if (*text && *text != '#') return true;
        mukca_text comments = {.at = t->comments, .size = COMMENTS, .used = strlen(t->comments)};
        const bool fits = comments.used + strlen(t->buffer) + 2 <= comments.size;
        if (!t->cell) mukca_text_put(&comments, "%s\n", fits ? t->buffer : "");
    }
    return false;
}

/* Whether semicolons separate the cells: no tabs, and at most one comma per cell, a decimal one. */
static bool has_semicolons(const char *line)
{
    if (!strchr(line, ';') || strchr(line, '\t')) return false;
    for (int commas = 0; *line; line++) {
        commas = *line == ';' ? 0 : commas + (*line == ',');
        if (commas > 1) return false;
    }
    return true;
}

/* Parse a number, with a decimal comma if semicolons separate the cells. */
static bool parse_number(double *value, const mukca_table *t, const char *cell)
{
    char copy[64];
    if (t->delimiter != ';') return mukca_number_parse(value, cell);
    const size_t comma = strcspn(cell, ",");
    if (!cell[comma] || strlen(cell) >= sizeof copy) return mukca_number_parse(value, cell);
    memcpy(copy, cell, strlen(cell) + 1);
    copy[comma] = '.';
    return mukca_number_parse(value, copy);
}

/* Determine delimiter and width from the first content line. */
static void set_shape(mukca_table *t)
{
    const char *line = t->buffer;
    t->delimiter = has_semicolons(line) ? ';' : mukca_cells_delimiter(line);
    t->n_columns = mukca_cells_count(line, t->delimiter);
    if (t->delimiter == ',' && t->n_columns == 1) {
        t->delimiter = ' ';
        t->n_columns = mukca_cells_count(line, ' ');
    }
    if (*line == '<') mukca_table_fail(t, -1, "is XML or HTML; expected a table");
    if (t->n_columns > MUKCA_TABLE_COLUMNS)
        mukca_table_fail(t, -1, "%d columns; at most %d are read", t->n_columns,
                         (int)MUKCA_TABLE_COLUMNS);
    if (t->status == MUKCA_OK) t->cell = take(t, (size_t)t->n_columns, sizeof *t->cell);
}

void mukca_table_check_names(mukca_table *t)
{
    for (int i = 0; i < t->n_columns && t->status == MUKCA_OK; i++)
        for (int k = 0; k < i && t->header[i][0]; k++)
            if (strcmp(t->header[i], t->header[k]) == 0)
                mukca_table_fail(t, -1, "two columns are called '%.40s'; rename one", t->header[i]);
}

static void read_header(mukca_table *t, mukca_table_kind kind)
{
    if (!read_content(t))
        mukca_table_fail(t, MUKCA_WHOLE_TABLE, "is empty; expected a header and rows");
    if (t->status != MUKCA_OK) return;
    set_shape(t);
    if (t->status != MUKCA_OK) return;
    const size_t width = (size_t)t->n_columns, length = strlen(t->buffer) + 1;
    t->header = take(t, width, sizeof *t->header);
    t->unit = take(t, width, sizeof *t->unit);
    t->used = take(t, width, sizeof *t->used);
    char *names = take(t, length, 1);
    if (t->status != MUKCA_OK) return;
    memcpy(names, t->buffer, length);
    mukca_cells_split(t->header, t->n_columns, names, t->delimiter);
    int numbers = 0;
    for (int i = 0; i < t->n_columns; i++) {
        double value;
        numbers += parse_number(&value, t, t->header[i]);
        t->unit[i] = mukca_unit_take(t->header[i]);
    }
    if (numbers < t->n_columns) mukca_table_check_names(t);
    if (numbers < t->n_columns) return;
    if (kind == MUKCA_HEADER)
        mukca_table_fail(t, -1, "starts with numbers; the first line must name the columns");
    t->header = NULL;
    t->pending = true;
}

/* ---- arrays of numpy ---- */

/* Whether the stream starts with an array of numpy; nothing is consumed. */
static bool is_array(FILE *stream)
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
        if (n < 1 || n > MUKCA_TABLE_COLUMNS) return false;
        a->columns *= n;
        if (a->columns > MUKCA_TABLE_COLUMNS) return false;
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

/* Replace *stream, such an array, by the same numbers as CSV; further dimensions than the first
 * become columns. */
static mukca_status read_array(FILE **stream, const char *path, mukca_error *error)
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

/* ---- */

mukca_status mukca_table_open(mukca_table *t, const char *path, mukca_table_kind kind,
                              mukca_error *error)
{
    memset(t, 0, sizeof *t);
    t->error = error;
    bool standard = strcmp(path, "-") == 0;
    if (strlen(path) < sizeof t->path) {
        snprintf(t->path, sizeof t->path, "%s", standard ? "standard input" : path);
        t->stream = standard ? stdin : fopen(path, "r");
        t->status = t->stream ? MUKCA_OK : mukca_file_fail(error, path);
    } else {
        t->status = mukca_fail(error, MUKCA_INPUT, "%.60s...: the file name is too long", path);
    }
    if (t->status == MUKCA_OK && !standard) setvbuf(t->stream, NULL, _IOFBF, READ_TOGETHER);
    if (t->status == MUKCA_OK) t->buffer = take(t, MUKCA_TABLE_LINE, 1);
    if (t->status == MUKCA_OK) t->comments = take(t, COMMENTS, 1);
    if (t->status == MUKCA_OK && is_array(t->stream))
        t->status = read_array(&t->stream, t->path, error);
    if (t->status == MUKCA_OK && kind != MUKCA_NO_HEADER) read_header(t, kind);
    return t->status;
}

bool mukca_table_next(mukca_table *t)
{
    if (t->source) return t->source->next(t);
    const bool more = (t->pending && t->status == MUKCA_OK) || read_content(t);
    t->pending = false;
    if (!more) return false;
    if (!t->cell) set_shape(t);
    if (t->status != MUKCA_OK) return false;
    if (mukca_cells_split(t->cell, t->n_columns, t->buffer, t->delimiter))
        t->row++;
    else
        mukca_table_fail(t, -1, "%d columns, but %d %s%s",
                         mukca_cells_count(t->buffer, t->delimiter), t->n_columns,
                         t->header ? "in the header" : "in the first row",
                         t->cut_off ? "; the last line is cut off" : "");
    return t->status == MUKCA_OK;
}

mukca_status mukca_table_close(mukca_table *t)
{
    const mukca_status status = t->status;
    if (t->source) t->source->close(t);
    if (t->stream && t->stream != stdin) fclose(t->stream);
    free(t->names);
    mukca_pool_free(&t->pool);
    *t = (mukca_table){.status = status, .line = t->line, .row = t->row};
    return status;
}

int mukca_table_find(const mukca_table *t, const char *name)
{
    for (int i = 0; t->header && i < t->n_columns; i++)
        if (strcmp(t->header[i], name) == 0) return i;
    return -1;
}

int mukca_table_use(mukca_table *t, const char *name)
{
    const int column = mukca_table_find(t, name);
    if (column >= 0) t->used[column] = true;
    return column;
}

int mukca_table_require(mukca_table *t, const char *name)
{
    const int column = mukca_table_use(t, name);
    if (column < 0) mukca_table_fail(t, -1, "no column '%s' in the header", name);
    return column;
}

bool mukca_table_has_unit(const mukca_table *t, int column)
{
    return t->unit && t->unit[column].factor > 0;
}

bool mukca_table_parse(double *value, const mukca_table *t, int column)
{
    if (!parse_number(value, t, t->cell[column])) return false;
    if (mukca_table_has_unit(t, column)) *value *= t->unit[column].factor;
    return true;
}

double mukca_table_number(mukca_table *t, int column)
{
    char fault[MUKCA_CELL_FAULT];
    double value;
    if (t->status != MUKCA_OK) return 0;
    if (t->value && !isnan(t->value[column])) return t->value[column];
    if (mukca_table_parse(&value, t, column)) return value;
    mukca_cell_number(&value, t->cell[column], fault);
    mukca_table_fail(t, column, "%s%s", fault,
                     t->header || t->row > 1 ? "" : "; this file has no header line");
    return 0;
}

int mukca_table_list(mukca_text *list, const mukca_table *table, bool unused)
{
    int n = 0;
    bool more = false;
    for (int c = 0; c < table->n_columns; c++) {
        if (unused && table->used[c]) continue;
        more = more || list->used + strlen(table->header[c]) + 8 >= list->size;
        if (!more) mukca_text_put(list, "%s%s", n ? ", " : "", table->header[c]);
        n++;
    }
    if (more) mukca_text_put(list, "%s...", list->used ? ", " : "");
    return n;
}
