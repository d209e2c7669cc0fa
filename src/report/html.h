/* Elements of HTML: escaped text and tables. */
#ifndef MUKCA_REPORT_HTML_H
#define MUKCA_REPORT_HTML_H

#include <stdio.h>

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

#endif
