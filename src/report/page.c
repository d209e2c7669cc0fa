/* Head and figures, shared by all pages. */
#include "report/page.h"

#include "mukca/version.h"
#include "report/html.h"
#include "report/style.h"

void mukca_page_begin(FILE *out, const mukca_page_head *head)
{
    fputs(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<meta name=\"color-scheme\" content=\"light dark\">\n<title>",
        out);
    mukca_html_escape(out, head->robot);
    fprintf(out, ": %s</title>\n<style>\n%s</style>\n</head>\n<body>\n<header>\n<h1>", head->kind,
            mukca_report_style);
    mukca_html_escape(out, head->robot);
    fprintf(out, ": %s</h1>\n<p>From ", head->kind);
    mukca_html_element(out, "code", head->from);
    fputs(" to ", out);
    mukca_html_element(out, "code", head->to);
    fprintf(out, ", mukca %s, %s</p>\n</header>\n<main>\n", MUKCA_VERSION, head->when);
}

void mukca_page_end(FILE *out)
{
    fputs("</main>\n</body>\n</html>\n", out);
}

mukca_status mukca_page_figure(const mukca_page_figures *to, mukca_plot *plot, mukca_error *error)
{
    char path[4096];
    if (!to->page) {
        snprintf(path, sizeof path, "%s/%s.%s", to->directory, plot->id, to->format);
        return mukca_plot_file(path, to->format, plot, error);
    }
    fprintf(to->page, "<figure%s>\n", plot->width > MUKCA_PLOT_HALF ? " class=\"broad\"" : "");
    const mukca_status status = mukca_plot_svg(to->page, plot, error);
    if (status != MUKCA_OK) return status;
    fputs("<figcaption>", to->page);
    mukca_html_element(to->page, "strong", plot->title);
    fputc(' ', to->page);
    mukca_html_escape(to->page, plot->words);
    fputs("</figcaption>\n</figure>\n", to->page);
    return MUKCA_OK;
}
