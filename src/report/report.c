/* The report's page: its head, its sections in the order of reading, and where the figures go. */
#include "report/report.h"

#include <stdlib.h>

#include "base/file.h"
#include "mukca/version.h"
#include "report/html.h"
#include "report/parts.h"
#include "report/style.h"

/* In the order of reading.  A section without any of its figures is omitted. */
static const struct {
    const char *id, *heading;
    mukca_report_figure *figures[2];
    mukca_report_text *text; /* after the figures, may be NULL */
} sections[] = {
    {"causes",
     "Remaining error and its causes",
     {mukca_report_ladder, mukca_report_arm},
     mukca_report_put_causes},
    {"placements", "Errors by placement", {mukca_report_placements}, mukca_report_put_placements},
    {"joints", "Errors by joint", {mukca_report_joints}, NULL},
    {"limits", "Detection limits", {NULL}, mukca_report_put_limits},
    {"samples", "Samples and recording faults", {mukca_report_samples}, mukca_report_put_faults},
    {"centres", "Predicted ball centres", {mukca_report_centres}, NULL},
    {"convergence", "Convergence", {mukca_report_convergence}, mukca_report_put_terms},
    {"generalisation", "Generalisation to other placements", {mukca_report_generalisation}, NULL},
    {"offsets", "Offsets", {mukca_report_offsets}, mukca_report_put_offsets},
    {"provenance", "Provenance", {NULL}, mukca_report_put_provenance},
};
enum { SECTIONS = sizeof sections / sizeof *sections };

/* Where figures go: into the page, or into files. */
typedef struct {
    FILE *page;                     /* NULL: files */
    const char *directory, *format; /* of files */
} destination;

static mukca_status put_figure(const destination *to, mukca_plot *plot, mukca_error *error)
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

/* All figures of a section. */
static mukca_status put_figures(const destination *to, int section, const mukca_report *r,
                                mukca_error *error)
{
    mukca_status status = MUKCA_OK;
    for (int k = 0; k < 2 && sections[section].figures[k]; k++) {
        bool more = true;
        for (int i = 0; more && status == MUKCA_OK; i++) {
            mukca_plot plot;
            if (r->progress &&
                !r->progress(r->progress_context, 1.0 * section / SECTIONS, "drawing"))
                return mukca_fail(error, MUKCA_INTERRUPTED,
                                  "interrupted; the page was not written");
            status = mukca_plot_open(&plot, error);
            more = status == MUKCA_OK && sections[section].figures[k](&plot, r, i);
            if (more) status = put_figure(to, &plot, error);
            mukca_plot_free(&plot);
        }
    }
    return status;
}

/* Write a section, and its entry of the list of sections into `list`. */
static mukca_status put_section(FILE *out, FILE *list, int section, const mukca_report *r,
                                mukca_error *error)
{
    const char *id = sections[section].id, *heading = sections[section].heading;
    if (sections[section].text == mukca_report_put_placements && r->data.n_sockets == 0)
        heading = "Position errors";
    char *figures = NULL;
    size_t size = 0;
    const destination page = {.page = open_memstream(&figures, &size)};
    if (!page.page) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the figures");
    mukca_status status = put_figures(&page, section, r, error);
    if (!mukca_file_close(page.page, &figures) && status == MUKCA_OK)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for the figures");
    if (status == MUKCA_OK && (size > 0 || !sections[section].figures[0])) {
        fprintf(list, "<li><a href=\"#%s\">%s</a></li>\n", id, heading);
        fprintf(out, "<section aria-labelledby=\"%s\">\n<h2 id=\"%s\">%s</h2>\n", id, id, heading);
        if (size > 0) fprintf(out, "<div class=\"figures\">\n%s</div>\n", figures);
        if (sections[section].text) sections[section].text(out, r);
        fputs("</section>\n", out);
    }
    free(figures);
    return status;
}

static void put_head(FILE *out, const mukca_report *r)
{
    fputs(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<meta name=\"color-scheme\" content=\"light dark\">\n<title>",
        out);
    mukca_html_escape(out, r->chain->robot);
    fprintf(out,
            ": calibration report</title>\n<style>\n%s</style>\n</head>\n<body>\n<header>\n<h1>",
            mukca_report_style);
    mukca_html_escape(out, r->chain->robot);
    fputs(": calibration report</h1>\n<p>From ", out);
    mukca_html_element(out, "code", r->chain->base);
    fputs(" to ", out);
    mukca_html_element(out, "code", r->chain->tip);
    fprintf(out, ", mukca %s, %s</p>\n</header>\n<main>\n", MUKCA_VERSION, r->when);
}

mukca_status mukca_report_write(FILE *out, const mukca_report *r, mukca_error *error)
{
    char *text = NULL;
    size_t size = 0;
    FILE *body = open_memstream(&text, &size); /* the list of sections comes before them */
    mukca_status status = MUKCA_OK;
    if (!body) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the page");
    put_head(out, r);
    mukca_report_put_verdict(out, r);
    mukca_report_put_key_figures(out, r);
    fputs("<nav aria-label=\"Sections\"><ul>\n", out);
    for (int k = 0; k < SECTIONS && status == MUKCA_OK; k++)
        status = put_section(body, out, k, r, error);
    if (!mukca_file_close(body, &text) && status == MUKCA_OK)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for the page");
    if (status == MUKCA_OK) fprintf(out, "</ul></nav>\n%s</main>\n</body>\n</html>\n", text);
    free(text);
    return status;
}

mukca_status mukca_report_write_figures(const char *directory, const char *format,
                                        const mukca_report *r, mukca_error *error)
{
    const destination files = {.directory = directory, .format = format};
    mukca_status status = MUKCA_OK;
    for (int k = 0; k < SECTIONS && status == MUKCA_OK; k++)
        status = put_figures(&files, k, r, error);
    return status;
}
