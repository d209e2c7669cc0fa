/* Pieces of HTML: escaped text and tables. */
#include "report/html.h"

#include <math.h>
#include <string.h>

#include "base/utf8.h"

void mukca_html_escape(FILE *out, const char *text)
{
    while (text && *text) {
        size_t n = mukca_utf8_fit(text, 1);
        for (size_t k = 2; n == 0 && k <= 4; k++) n = mukca_utf8_fit(text, k);
        if (n == 0) /* a byte outside UTF-8 would make the page invalid */
            fputc('?', out);
        else if (*text == '&')
            fputs("&amp;", out);
        else if (*text == '<')
            fputs("&lt;", out);
        else if (*text == '>')
            fputs("&gt;", out);
        else if (*text == '"')
            fputs("&quot;", out);
        else
            fwrite(text, 1, n, out);
        text += n ? n : 1;
    }
}

/* Write a heading without its mark; return the next one. */
static const char *heading(FILE *out, const char *column)
{
    char text[128];
    const size_t n = strcspn(column, "|"), mark = *column == '#';
    snprintf(text, sizeof text, "%.*s", (int)(n - mark), column + mark);
    mukca_html_escape(out, text);
    return column + n + (column[n] == '|');
}

void mukca_html_table_begin(mukca_html_table *table, const char *caption)
{
    FILE *out = table->out;
    table->open = false;
    fprintf(out, "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"");
    mukca_html_escape(out, caption);
    fprintf(out, "\">\n<table%s>\n<caption>", table->cards ? " class=\"cards\"" : "");
    mukca_html_escape(out, caption);
    fputs("</caption>\n<thead><tr>", out);
    for (const char *column = table->columns; *column;) {
        fprintf(out, "<th scope=\"col\"%s>", *column == '#' ? " class=\"n\"" : "");
        column = heading(out, column);
        fputs("</th>", out);
    }
    fputs("</tr></thead>\n<tbody>\n", out);
}

void mukca_html_table_row(mukca_html_table *table)
{
    fputs(table->open ? "</tr>\n<tr>" : "<tr>", table->out);
    table->open = true;
    table->at = table->columns;
}

static void begin_cell(mukca_html_table *table)
{
    const char *label = table->at;
    const size_t n = strcspn(label, "|");
    fputs(*label == '#' ? "<td class=\"n\"" : "<td", table->out);
    if (table->cards) {
        fputs(" data-label=\"", table->out);
        heading(table->out, label);
        fputc('"', table->out);
    }
    fputc('>', table->out);
    table->at = label + n + (label[n] == '|');
}

void mukca_html_table_text(mukca_html_table *table, const char *text)
{
    begin_cell(table);
    mukca_html_escape(table->out, text);
    fputs("</td>", table->out);
}

void mukca_html_table_number(mukca_html_table *table, double value, int decimals)
{
    begin_cell(table);
    if (decimals >= 0 && fabs(value) < 0.5 * pow(10, -decimals)) value = 0; /* no "-0.00" */
    if (!isfinite(value))
        fputs("&ndash;", table->out);
    else if (decimals < 0)
        fprintf(table->out, "%.*g", -decimals, value);
    else
        fprintf(table->out, "%.*f", decimals, value);
    fputs("</td>", table->out);
}

void mukca_html_table_end(mukca_html_table *table)
{
    fprintf(table->out, "%s</tbody>\n</table>\n</div>\n", table->open ? "</tr>\n" : "");
}
