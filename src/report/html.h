/* Pieces of HTML: escaped text and tables. */
#ifndef MUKCA_REPORT_HTML_H
#define MUKCA_REPORT_HTML_H

#include <stdio.h>

/* `text` with the characters that HTML and XML reserve escaped. */
void mukca_html_escape(FILE *out, const char *text);

/* The same with a capital first letter, and what is between backticks as code. */
void mukca_html_sentence(FILE *out, const char *text);

/* "<b>", `text` escaped, "</b>" for the element `name`. */
void mukca_html_element(FILE *out, const char *name, const char *text);

/* A table being written; it appears with its first row. */
typedef struct {
    FILE *out;
    const char *caption;
    const char *columns; /* headings separated by '|'; those that begin with '#' are of numbers */
    const char *style;   /* "cards": on a narrow screen each row is a list of its cells; "matrix":
                            numbers of 0 to 1 shade their cells; NULL: the table scrolls by itself */
    const char *at;      /* heading of the next cell; NULL before the first row */
} mukca_html_table;

/* Begin a row with the cells that `format` separates by tabs.  A number that is not finite becomes
 * a dash.  At most 8191 characters. */
void mukca_html_row(mukca_html_table *table, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Append cells to the row. */
void mukca_html_cells(mukca_html_table *table, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

void mukca_html_table_end(mukca_html_table *table);

#endif
