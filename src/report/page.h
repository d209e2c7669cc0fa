/* Pages: a head, an opening text, and sections with figures. */
#ifndef MUKCA_REPORT_PAGE_H
#define MUKCA_REPORT_PAGE_H

#include <stdbool.h>
#include <stdio.h>

#include "mukca/status.h"

/* ---- elements of HTML: escaped text and tables (html.c) ---- */

/* Write `text` with the reserved characters of HTML and XML escaped. */
void mukca_html_escape(FILE *out, const char *text);

/* The same with a capital first letter, and text between backticks as code. */
void mukca_html_sentence(FILE *out, const char *text);

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

/* Start a row with the cells that `format` separates by tabs, at most 8191 characters.  A number
 * that is not finite becomes a dash. */
void mukca_html_row(mukca_html_table *table, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Append cells to the row. */
void mukca_html_cells(mukca_html_table *table, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

void mukca_html_table_end(mukca_html_table *table);

/* ---- figures: points over two axes, as SVG with a text alternative (plot.c) ---- */

/* Series of points.  Each has a colour of the page's style sheet, which distinguishes it for
 * colour-blind readers (palette of Okabe and Ito, "Color Universal Design", 2008), and a shape,
 * which distinguishes it in grey. */
typedef enum { MUKCA_PLOT_AFTER, MUKCA_PLOT_BEFORE, MUKCA_PLOT_SERIES } mukca_plot_series;

typedef struct {
    mukca_plot_series series;
    double at[2], low, high; /* low, high: its interval, NaN for none */
} mukca_plot_point;

/* A name at a position of the horizontal axis, instead of its numbers. */
typedef struct {
    double x;
    const char *name;
} mukca_plot_tic;

/* A figure under construction, zeroed at first; titles and names must outlive it. */
typedef struct {
    char words[4096]; /* the content as text */
    char id[64];      /* letters, digits, '-'; unique on the page */
    char title[160], label[2][80];
    int height;     /* px */
    bool brief;     /* the caption is the title alone: a table has the numbers */
    bool from_zero; /* the vertical axis begins at 0 */
    double band[3]; /* lower end, middle and upper end of a range of the vertical axis; all 0:
                       none */
    const char *key[MUKCA_PLOT_SERIES]; /* title of a series; NULL: none */
    mukca_plot_point *points;           /* [n_points] */
    mukca_plot_tic *tics;               /* [n_tics] */
    int n_points, n_tics;
    bool failed; /* out of memory */
} mukca_plot;

void mukca_plot_free(mukca_plot *plot); /* harmless on a zeroed figure */

/* Add a point, unless it is not finite; low, high: its interval, NaN for none. */
void mukca_plot_add(mukca_plot *plot, mukca_plot_series series, const double at[2], double low,
                    double high);
void mukca_plot_name(mukca_plot *plot, double x, const char *name);

/* 1, 2 or 5 times a power of ten, at most x. */
double mukca_plot_round(double x);

/* Write the figure, which has not failed, as an <svg> element. */
void mukca_plot_svg(FILE *out, const mukca_plot *plot);

/* A section; `content` is that of the page. */
typedef struct {
    const char *id, *heading;
    /* Draw figure `index` on a zeroed plot; false: there is none.  NULL: no figures. */
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
