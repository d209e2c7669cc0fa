/* What all pages share: head and figures. */
#ifndef MUKCA_REPORT_PAGE_H
#define MUKCA_REPORT_PAGE_H

#include "report/plot.h"

/* Where figures go: into the page, or into files. */
typedef struct {
    FILE *page;                     /* NULL: files */
    const char *directory, *format; /* of files: "png", "pdf" or "svg" */
} mukca_page_figures;

/* Title "ROBOT: KIND", the links, and when it was made (UTC). */
typedef struct {
    const char *robot, *kind, *from, *to, *when;
} mukca_page_head;

/* Write all up to the first section, and the end. */
void mukca_page_begin(FILE *out, const mukca_page_head *head);
void mukca_page_end(FILE *out);

/* Draw a figure, in the page with its title and description below.  Errors: those of
 * mukca_plot_svg and mukca_plot_file. */
mukca_status mukca_page_figure(const mukca_page_figures *to, mukca_plot *plot, mukca_error *error);

#endif
