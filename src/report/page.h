/* Head and figures, shared by all pages. */
#ifndef MUKCA_REPORT_PAGE_H
#define MUKCA_REPORT_PAGE_H

#include "report/plot.h"

/* Destination of figures: the page, or files. */
typedef struct {
    FILE *page;                     /* NULL: files */
    const char *directory, *format; /* of the files: "png", "pdf" or "svg" */
} mukca_page_figures;

/* Title "ROBOT: KIND", links, and date (UTC). */
typedef struct {
    const char *robot, *kind, *from, *to, *when;
} mukca_page_head;

/* Write everything before the first section; and the end of the page. */
void mukca_page_begin(FILE *out, const mukca_page_head *head);
void mukca_page_end(FILE *out);

/* Draw a figure; in a page its title and description follow.  Errors: those of mukca_plot_svg and
 * mukca_plot_file. */
mukca_status mukca_page_figure(const mukca_page_figures *to, mukca_plot *plot, mukca_error *error);

#endif
