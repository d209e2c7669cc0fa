/* Pages: a head, an opening text, and sections with figures. */
#ifndef MUKCA_REPORT_PAGE_H
#define MUKCA_REPORT_PAGE_H

#include <stdbool.h>
#include <stdio.h>

/* ---- elements of HTML: escaped text and tables (html.c) ---- */

/* Write `text` with the reserved characters of HTML and XML escaped. */
void mukca_html_escape(FILE *out, const char *text);

/* Write a sentence, if there is one, between `before` and `after`: escaped, with a capital first
 * letter, and text between backticks as code. */
void mukca_html_sentence(FILE *out, const char *before, const char *text, const char *after);

/* Write `text`, escaped, as the content of element `name`. */
void mukca_html_element(FILE *out, const char *name, const char *text);

/* A table under construction; its header is written with the first row. */
typedef struct {
    FILE *out;
    const char *caption;
    const char *columns; /* headings separated by '|'; '#' marks a column of numbers, "bar" one of
                            bars, percent of its width */
    const char *style;   /* "cards": each row is a list of its cells on a narrow screen; NULL: the
                            table scrolls by itself */
    const char *at;      /* heading of the next cell; NULL before the first row */
} mukca_html_table;

/* Write a row with the cells that `format` separates by tabs, at most 8191 characters.  A number
 * that is not finite becomes a dash. */
void mukca_html_row(mukca_html_table *table, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

void mukca_html_table_end(mukca_html_table *table);

/* ---- figures: points over two axes, as SVG with a text alternative (plot.c) ---- */

/* Series of points.  Each has a colour of the page's style sheet, which distinguishes it for
 * colour-blind readers (palette of Okabe and Ito, "Color Universal Design", 2008), and a shape,
 * which distinguishes it in grey. */
typedef enum {
    MUKCA_PLOT_AFTER,
    MUKCA_PLOT_BEFORE,
    MUKCA_PLOT_MEASURED, /* lines only */
    MUKCA_PLOT_SERIES
} mukca_plot_series;

typedef struct {
    mukca_plot_series series;
    double at[2];
} mukca_plot_point;

/* A figure; the caption is its title: a table has the numbers. */
typedef struct {
    const char *words; /* the content as text */
    const char *id;    /* letters, digits, '-'; unique on the page */
    const char *title, *label[2];
    const char *key[MUKCA_PLOT_SERIES]; /* title of a series; NULL: none */
    mukca_plot_point *points;           /* [n_points] of the caller */
    int n_points;
    bool lines; /* through the points of each series, in their order, without marks */
} mukca_plot;

/* Write the figure as a <figure> element. */
void mukca_plot_put(FILE *out, const mukca_plot *plot);

/* Write a part of a page from its content. */
typedef void mukca_page_part(FILE *out, const void *content);

typedef struct {
    const char *id, *heading;
    mukca_page_part *put;
} mukca_page_section;

typedef struct {
    const char *robot, *kind, *from, *to; /* title "ROBOT: KIND", links */
    const char *command, *when;           /* that made the page, date (UTC) */
    mukca_page_part *open;
    const mukca_page_section *sections;
    int n_sections;
    const void *content;
} mukca_page;

void mukca_page_write(FILE *out, const mukca_page *page);

#endif
