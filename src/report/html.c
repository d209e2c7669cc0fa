/* Elements of HTML: escaped text and tables. */
#include "report/page.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"

static void escape(FILE *out, const char *text, size_t length)
{
    static const char special[] = "&<>\"";
    static const char *const escaped[] = {"&amp;", "&lt;", "&gt;", "&quot;"};
    for (const char *end = text + length; text < end;) {
        const char *found = strchr(special, *text);
        size_t n = mukca_utf8_fit(text, 1);
        for (size_t k = 2; n == 0 && k <= 4; k++) n = mukca_utf8_fit(text, k);
        if (n == 0) /* a byte that is not UTF-8 would make the page invalid */
            fputc('?', out);
        else if (found)
            fputs(escaped[found - special], out);
        else
            fwrite(text, 1, n, out);
        text += n ? n : 1;
    }
}

void mukca_html_escape(FILE *out, const char *text)
{
    escape(out, text, strlen(text));
}

void mukca_html_element(FILE *out, const char *name, const char *text)
{
    fprintf(out, "<%s>", name);
    mukca_html_escape(out, text);
    fprintf(out, "</%s>", name);
}

void mukca_html_sentence(FILE *out, const char *before, const char *text, const char *after)
{
    bool code = false;
    if (!*text) return;
    fputs(before, out);
    if (islower((unsigned char)*text)) fputc(toupper((unsigned char)*text++), out);
    while (*text) {
        const size_t length = strcspn(text, "`");
        escape(out, text, length);
        text += length;
        if (*text == '\0') break;
        code = !code;
        fputs(code ? "<code>" : "</code>", out);
        text++;
    }
    fputs(after, out);
}

/* Write a heading without its mark; returns the next one. */
static const char *put_heading(FILE *out, const char *column)
{
    const size_t length = strcspn(column, "|"), mark = *column == '#';
    if (strncmp(column, "bar|", 4) != 0) escape(out, column + mark, length - mark);
    return column + length + (column[length] == '|');
}

static void begin_table(mukca_html_table *table)
{
    FILE *out = table->out;
    fputs("<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"", out);
    mukca_html_escape(out, table->caption);
    fprintf(out, "\">\n<table class=\"%s\">\n", table->style ? table->style : "");
    mukca_html_element(out, "caption", table->caption);
    fputs("\n<thead><tr>", out);
    for (const char *column = table->columns; *column;) {
        fprintf(out, "<th scope=\"col\"%s>", *column == '#' ? " class=\"n\"" : "");
        column = put_heading(out, column);
        fputs("</th>", out);
    }
    fputs("</tr></thead>\n<tbody>\n", out);
}

static void put_cell(mukca_html_table *table, const char *text)
{
    FILE *out = table->out;
    const bool cards = table->style && strcmp(table->style, "cards") == 0;
    if (strncmp(table->at, "bar|", 4) == 0) {
        fprintf(out, "<td class=\"bar\"><i style=\"width:%s%%\"></i></td>", text);
        table->at += 4;
        return;
    }
    const bool number = *table->at == '#';
    const double value = number ? strtod(text, NULL) : 0;
    fputs(number ? "<td class=\"n\"" : "<td", out);
    if (cards) {
        fputs(" data-label=\"", out);
        put_heading(out, table->at);
        fputc('"', out);
    }
    fputc('>', out);
    if (!isfinite(value))
        fputs("&ndash;", out);
    else
        mukca_html_escape(out, text + (number && value == 0 && *text == '-')); /* avoids "-0.00" */
    fputs("</td>", out);
    table->at += strcspn(table->at, "|");
    table->at += *table->at == '|';
}

void mukca_html_row(mukca_html_table *table, const char *format, ...)
{
    char text[8192], *cell = text;
    va_list values;
    va_start(values, format);
    vsnprintf(text, sizeof text, format, values);
    va_end(values);
    if (!table->at) begin_table(table);
    fputs(table->at ? "</tr>\n<tr>" : "<tr>", table->out);
    table->at = table->columns;
    for (char *tab; (tab = strchr(cell, '\t')); cell = tab + 1) {
        *tab = '\0';
        put_cell(table, cell);
    }
    put_cell(table, cell);
}

void mukca_html_table_end(mukca_html_table *table)
{
    if (table->at) fputs("</tr>\n</tbody>\n</table>\n</div>\n", table->out);
}
