/* A figure being drawn: its gnuplot script and its description in words. */
#ifndef MUKCA_REPORT_SHEET_H
#define MUKCA_REPORT_SHEET_H

#include <stdio.h>

#include "report/plot.h"

typedef struct {
    FILE *script, *description; /* write here */
    char *text, *words;         /* what was written */
    size_t sizes[2];
    char id[64], title[160];
    int width, height; /* px */
} mukca_sheet;

enum {
    MUKCA_SHEET_HALF = 480, /* px: two figures in a row; whole and readable on a phone */
    MUKCA_SHEET_FULL = 960
};

/* Open an empty sheet; finish it with mukca_sheet_close and mukca_sheet_free.
 * Errors: MUKCA_MEMORY. */
mukca_status mukca_sheet_open(mukca_sheet *sheet, mukca_error *error);

/* Name the figure and set the style that all figures share. */
void mukca_sheet_begin(mukca_sheet *sheet, const char *id, const char *title, int width,
                       int height);

/* Add to the description. */
void mukca_sheet_describe(mukca_sheet *sheet, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Write the name of a horizontal line of data just above it, at the left edge. */
void mukca_sheet_name_line(mukca_sheet *sheet, const char *name, double y);

/* End the script; `figure` points into the sheet.  Errors: MUKCA_MEMORY. */
mukca_status mukca_sheet_close(mukca_figure *figure, mukca_sheet *sheet, mukca_error *error);
void mukca_sheet_free(mukca_sheet *sheet); /* harmless on a zeroed one */

#endif
