/* Pages: head, list of sections, figures with their texts. */
#include "report/page.h"

#include <stdlib.h>

#include "base/file.h"
#include "mukca/version.h"
#include "report/html.h"
#include "report/style.h"

static void put_head(FILE *out, const mukca_page *p)
{
    fputs(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<meta name=\"color-scheme\" content=\"light dark\">\n<title>",
        out);
    mukca_html_escape(out, p->robot);
    fprintf(out, ": %s</title>\n<style>\n%s</style>\n</head>\n<body>\n<header>\n<h1>", p->kind,
            mukca_report_style);
    mukca_html_escape(out, p->robot);
    fprintf(out, ": %s</h1>\n<p>From ", p->kind);
    mukca_html_element(out, "code", p->from);
    fputs(" to ", out);
    mukca_html_element(out, "code", p->to);
    fprintf(out, ", mukca %s, %s</p>\n</header>\n<main>\n", MUKCA_VERSION, p->when);
}

/* Write a figure with its title and description to `out`. */
static mukca_status put_figure(FILE *out, mukca_plot *plot, mukca_error *error)
{
    fprintf(out, "<figure%s>\n", plot->width > MUKCA_PLOT_HALF ? " class=\"broad\"" : "");
    const mukca_status status = mukca_plot_svg(out, plot, error);
    if (status != MUKCA_OK) return status;
    fputs("<figcaption>", out);
    mukca_html_element(out, "strong", plot->title);
    fputc(' ', out);
    mukca_html_escape(out, plot->words);
    fputs("</figcaption>\n</figure>\n", out);
    return MUKCA_OK;
}

/* Draw all figures of section k, to `out`, or (NULL) to files. */
static mukca_status put_figures(FILE *out, const char *directory, const char *format,
                                const mukca_page *p, int k, mukca_error *error)
{
    mukca_status status = MUKCA_OK;
    bool more = p->sections[k].figure != NULL;
    for (int i = 0; more && status == MUKCA_OK; i++) {
        mukca_plot plot;
        char path[4096];
        if (p->progress && !p->progress(p->progress_context, 1.0 * k / p->n_sections, "drawing"))
            return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted; the page was not written");
        status = mukca_plot_open(&plot, error);
        more = status == MUKCA_OK && p->sections[k].figure(&plot, p->content, i);
        if (more && out) {
            status = put_figure(out, &plot, error);
        } else if (more) {
            snprintf(path, sizeof path, "%s/%s.%s", directory, plot.id, format);
            status = mukca_plot_file(path, format, &plot, error);
        }
        mukca_plot_free(&plot);
    }
    return status;
}

/* Write section k, and its entry in the list of sections to `list`. */
static mukca_status put_section(FILE *out, FILE *list, const mukca_page *p, int k,
                                mukca_error *error)
{
    const mukca_page_section *s = &p->sections[k];
    char *figures = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&figures, &size);
    if (!stream) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the figures");
    mukca_status status = put_figures(stream, NULL, NULL, p, k, error);
    if (!mukca_file_close(stream, &figures) && status == MUKCA_OK)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for the figures");
    if (status == MUKCA_OK && (size > 0 || !s->figure)) {
        fprintf(list, "<li><a href=\"#%s\">%s</a></li>\n", s->id, s->heading);
        fprintf(out, "<section aria-labelledby=\"%s\">\n<h2 id=\"%s\">%s</h2>\n", s->id, s->id,
                s->heading);
        if (size > 0) fprintf(out, "<div class=\"figures\">\n%s</div>\n", figures);
        if (s->text) s->text(out, p->content);
        fputs("</section>\n", out);
    }
    free(figures);
    return status;
}

mukca_status mukca_page_write(FILE *out, const mukca_page *p, mukca_error *error)
{
    char *text = NULL;
    size_t size = 0;
    FILE *body = open_memstream(&text, &size); /* the list of sections precedes them */
    mukca_status status = MUKCA_OK;
    if (!body) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the page");
    put_head(out, p);
    p->open(out, p->content);
    fputs("<nav aria-label=\"Sections\"><ul>\n", out);
    for (int k = 0; k < p->n_sections && status == MUKCA_OK; k++)
        status = put_section(body, out, p, k, error);
    if (!mukca_file_close(body, &text) && status == MUKCA_OK)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for the page");
    if (status == MUKCA_OK) fprintf(out, "</ul></nav>\n%s</main>\n</body>\n</html>\n", text);
    free(text);
    return status;
}

mukca_status mukca_page_write_figures(const char *directory, const char *format,
                                      const mukca_page *p, mukca_error *error)
{
    mukca_status status = MUKCA_OK;
    for (int k = 0; k < p->n_sections && status == MUKCA_OK; k++)
        status = put_figures(NULL, directory, format, p, k, error);
    return status;
}
