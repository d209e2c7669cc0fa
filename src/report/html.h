/* Pieces of HTML: escaped text and tables. */
#ifndef MUKCA_REPORT_HTML_H
#define MUKCA_REPORT_HTML_H

#include <stdbool.h>
#include <stdio.h>

/* `text` with the characters that HTML and XML reserve escaped; NULL writes nothing. */
void mukca_html_escape(FILE *out, const char *text);

/* A table being written, cell after cell.  `columns` holds the headings, separated by '|'; those
 * that begin with '#' are columns of numbers.  On a narrow screen a table of cards shows each row
 * as a list of its cells; any other table scrolls by itself. */
typedef struct {
    FILE *out;
    const char *columns;
    bool cards;
    const char *at; /* heading of the next cell */
    bool open;      /* a row has begun */
} mukca_html_table;

/* Write the caption and the headings. */
void mukca_html_table_begin(mukca_html_table *table, const char *caption);
void mukca_html_table_row(mukca_html_table *table);
void mukca_html_table_text(mukca_html_table *table, const char *text);

/* A number with `decimals` digits after the point, or -decimals significant ones; a dash where it
 * is not finite. */
void mukca_html_table_number(mukca_html_table *table, double value, int decimals);
void mukca_html_table_end(mukca_html_table *table);

#endif
