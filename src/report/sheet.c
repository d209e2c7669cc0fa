/* A figure being drawn: its gnuplot script and its description in words. */
#include "report/sheet.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

mukca_status mukca_sheet_open(mukca_sheet *sheet, mukca_error *error)
{
    memset(sheet, 0, sizeof *sheet);
    sheet->script = open_memstream(&sheet->text, &sheet->sizes[0]);
    sheet->description = open_memstream(&sheet->words, &sheet->sizes[1]);
    if (sheet->script && sheet->description) return MUKCA_OK;
    mukca_sheet_free(sheet);
    return mukca_fail(error, MUKCA_MEMORY, "out of memory for the figures");
}

void mukca_sheet_begin(mukca_sheet *sheet, const char *id, const char *title, int width, int height)
{
    snprintf(sheet->id, sizeof sheet->id, "%s", id);
    snprintf(sheet->title, sizeof sheet->title, "%s", title);
    sheet->width = width;
    sheet->height = height;
    fputs(
        "set border 3 linewidth 0.8\n"
        "set tics nomirror out scale 0.6\n"
        "set grid linecolor 'gray' linewidth 0.4 dashtype 3\n"
        "set key above left horizontal Left reverse samplen 2\n",
        sheet->script);
}

void mukca_sheet_describe(mukca_sheet *sheet, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vfprintf(sheet->description, format, args);
    va_end(args);
}

void mukca_sheet_name_line(mukca_sheet *sheet, const char *name, double y)
{
    fputs("set label ", sheet->script);
    mukca_plot_quote(sheet->script, name);
    fprintf(sheet->script, " at graph 0, first %g left offset 0.5, 0.75\n", y);
}

mukca_status mukca_sheet_close(mukca_figure *figure, mukca_sheet *sheet, mukca_error *error)
{
    bool failed = fclose(sheet->script) != 0;
    failed |= fclose(sheet->description) != 0;
    sheet->script = sheet->description = NULL;
    if (failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the figures");
    *figure = (mukca_figure){.id = sheet->id,
                             .title = sheet->title,
                             .description = sheet->words,
                             .width = sheet->width,
                             .height = sheet->height};
    return MUKCA_OK;
}

void mukca_sheet_free(mukca_sheet *sheet)
{
    if (sheet->script) fclose(sheet->script);
    if (sheet->description) fclose(sheet->description);
    free(sheet->text);
    free(sheet->words);
    memset(sheet, 0, sizeof *sheet);
}
