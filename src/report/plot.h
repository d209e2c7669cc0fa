/* Figures by gnuplot: a script in; SVG that fits into a page, or an image file, out. */
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

typedef struct {
    const char *id; /* letters, digits, '-'; unique in the page */
    const char *title;
    const char *description; /* the content as text */
    int width, height;       /* px */
} mukca_figure;

/* Run `script` and write the figure as an <svg> element with a text alternative; its colours follow
 * the page's style sheet.  Errors: MUKCA_INPUT (gnuplot is missing or refuses), MUKCA_MEMORY. */
mukca_status mukca_plot_svg(FILE *out, const mukca_figure *figure, const char *script,
                            mukca_error *error);

/* The same as a file of format "png", "pdf" or "svg"; an existing one is replaced. */
mukca_status mukca_plot_file(const char *path, const char *format, const mukca_figure *figure,
                             const char *script, mukca_error *error);

/* A gnuplot string constant of `text`, quoted so that nothing in it is interpreted. */
void mukca_plot_quote(FILE *script, const char *text);

#endif
