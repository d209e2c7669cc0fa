/* Figures by gnuplot: a script and a description in; SVG that fits into a page, or a file, out. */
#ifndef MUKCA_REPORT_PLOT_H
#define MUKCA_REPORT_PLOT_H

#include <stdio.h>

#include "mukca/status.h"

/* Colours of the scripts (`lc rgb PLOT_BEFORE`), three of the palette of Okabe and Ito, "Color
 * Universal Design" (2008), that colour-blind people distinguish; point shapes and dashes
 * distinguish them in grey.  The page's style sheet restates them for its dark scheme. */
#define PLOT_BEFORE "'#d55e00'"
#define PLOT_AFTER "'#0072b2'"
#define PLOT_THIRD "'#009e73'"

enum {
    MUKCA_PLOT_HALF = 480, /* px: two figures in a row; whole and readable on a phone */
    MUKCA_PLOT_FULL = 960
};

/* A figure being drawn. */
typedef struct {
    FILE *script, *description; /* write here; the description is the content as text */
    char *text, *words;         /* what was written */
    size_t sizes[2];
    char id[64]; /* letters, digits, '-'; unique in the page */
    char title[160];
    int width, height; /* px */
} mukca_plot;

/* Open an empty figure; close it with mukca_plot_free, also after an error.
 * Errors: MUKCA_MEMORY. */
mukca_status mukca_plot_open(mukca_plot *plot, mukca_error *error);
void mukca_plot_free(mukca_plot *plot);

/* Name the figure and set the style that all figures share. */
void mukca_plot_begin(mukca_plot *plot, const char *id, const char *title, int width, int height);

/* A gnuplot string constant that shows `text` as the name of a tic; nothing in it is interpreted.
 */
void mukca_plot_tic(FILE *script, const char *text);

/* Place of a label: just above the horizontal line of data at an integer y, at the left edge. */
#define MUKCA_PLOT_ABOVE "at graph 0, first %d left offset 0.5, 0.75"

/* `text` at the place that `format` says ("at 1, 2 left"). */
void mukca_plot_label(mukca_plot *plot, const char *text, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Run the script and write the figure as an <svg> element with a text alternative; its colours
 * follow the page's style sheet.  Errors: MUKCA_INPUT (gnuplot is missing or refuses),
 * MUKCA_MEMORY, MUKCA_INTERRUPTED. */
mukca_status mukca_plot_svg(FILE *out, mukca_plot *plot, mukca_error *error);

/* The same as a file of format "png", "pdf" or "svg"; an existing one is replaced. */
mukca_status mukca_plot_file(const char *path, const char *format, mukca_plot *plot,
                             mukca_error *error);

#endif
