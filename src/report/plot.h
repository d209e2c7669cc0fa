/* Figures by gnuplot, from a script and a description: SVG for a page, or a file. */
#ifndef MUKCA_REPORT_PLOT_H
#define MUKCA_REPORT_PLOT_H

#include <stdbool.h>
#include <stdio.h>

#include "mukca/status.h"

/* Colours of the scripts (`lc rgb PLOT_BEFORE`): three of the palette of Okabe and Ito, "Color
 * Universal Design" (2008), which colour-blind readers can distinguish; point shapes and dashes
 * distinguish them in grey.  The page's style sheet replaces them in its dark scheme. */
#define PLOT_BEFORE "'#d55e00'"
#define PLOT_AFTER "'#0072b2'"
#define PLOT_THIRD "'#009e73'"

enum {
    MUKCA_PLOT_HALF = 480, /* px: two figures per row; legible on a phone */
    MUKCA_PLOT_FULL = 960
};

/* A figure under construction. */
typedef struct {
    FILE *script, *description; /* output of the caller; the description is the content as text */
    char *text, *words;         /* their content */
    size_t sizes[2];
    char id[64]; /* letters, digits, '-'; unique on the page */
    char title[160];
    int width, height; /* px */
    bool brief;        /* the caption is the title alone: a table has the numbers */
} mukca_plot;

/* Create an empty figure; free it with mukca_plot_free, also after an error.  Errors:
 * MUKCA_MEMORY. */
mukca_status mukca_plot_open(mukca_plot *plot, mukca_error *error);
void mukca_plot_free(mukca_plot *plot);

/* Set the figure's name and size, and print the style shared by all figures. */
void mukca_plot_begin(mukca_plot *plot, const char *id, const char *title, int width, int height);

/* Print `text` as a gnuplot string constant for the name of a tic, without interpretation. */
void mukca_plot_tic(FILE *script, const char *text);

/* Print the label `text` at the position given by `format` ("at 1, 2 left"). */
void mukca_plot_label(mukca_plot *plot, const char *text, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Run the script and write the figure as an <svg> element with a text alternative; its colours
 * follow the page's style sheet.  Errors: MUKCA_INPUT (gnuplot is missing or reports an error),
 * MUKCA_MEMORY, MUKCA_INTERRUPTED. */
mukca_status mukca_plot_svg(FILE *out, mukca_plot *plot, mukca_error *error);

/* The same as a file of format "png", "pdf" or "svg"; an existing file is replaced. */
mukca_status mukca_plot_file(const char *path, const char *format, mukca_plot *plot,
                             mukca_error *error);

#endif
