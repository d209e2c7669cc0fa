/* Pages: a head, an opening text, and sections with figures. */
#ifndef MUKCA_REPORT_PAGE_H
#define MUKCA_REPORT_PAGE_H

#include <stdbool.h>

#include "report/plot.h"

/* A section; `content` is that of the page. */
typedef struct {
    const char *id, *heading;
    /* Draw figure `index` on an open plot; false: there is none.  NULL: no figures; a section
     * without any of its figures is omitted. */
    bool (*figure)(mukca_plot *plot, const void *content, int index);
    void (*text)(FILE *out, const void *content); /* after the figures; NULL: none */
} mukca_page_section;

typedef struct {
    const char *robot, *kind, *from, *to, *when; /* title "ROBOT: KIND", links, date (UTC) */
    void (*open)(FILE *out, const void *content);
    const mukca_page_section *sections;
    int n_sections;
    const void *content;
} mukca_page;

/* Write the page.  Errors: MUKCA_MEMORY. */
mukca_status mukca_page_write(FILE *out, const mukca_page *page, mukca_error *error);

#endif
