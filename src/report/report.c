/* The page of the report: head, sections in reading order, and their figures. */
#include "report/report.h"

#include <stdlib.h>

#include "base/file.h"
#include "report/page.h"
#include "report/parts.h"

/* Sections in reading order; one without any of its figures is omitted. */
static const struct {
    const char *id, *heading;
    mukca_report_figure *figure; /* NULL: none */
    mukca_report_text *text;     /* after the figures, may be NULL */
} sections[] = {
    {"causes", "Remaining error and its causes", mukca_report_ladder, mukca_report_put_causes},
    {"placements", "Errors by placement", mukca_report_placements, mukca_report_put_placements},
    {"joints", "Errors by joint", mukca_report_joints, NULL},
    {"limits", "Detection limits", NULL, mukca_report_put_limits},
    {"samples", "Samples and recording faults", mukca_report_samples, mukca_report_put_faults},
    {"centres", "Predicted ball centres", mukca_report_centres, NULL},
    {"offsets", "Offsets", NULL, mukca_report_put_offsets},
    {"provenance", "Provenance", NULL, mukca_report_put_provenance},
};
enum { SECTIONS = sizeof sections / sizeof *sections };

/* Draw all figures of a section. */
static mukca_status put_figures(const mukca_page_figures *to, int section, const mukca_report *r,
                                mukca_error *error)
{
    mukca_status status = MUKCA_OK;
    bool more = sections[section].figure != NULL;
    for (int i = 0; more && status == MUKCA_OK; i++) {
        mukca_plot plot;
        if (r->progress && !r->progress(r->progress_context, 1.0 * section / SECTIONS, "drawing"))
            return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted; the page was not written");
        status = mukca_plot_open(&plot, error);
        more = status == MUKCA_OK && sections[section].figure(&plot, r, i);
        if (more) status = mukca_page_figure(to, &plot, error);
        mukca_plot_free(&plot);
    }
    return status;
}

/* Write a section, and its entry in the list of sections to `list`. */
static mukca_status put_section(FILE *out, FILE *list, int section, const mukca_report *r,
                                mukca_error *error)
{
    const char *id = sections[section].id, *heading = sections[section].heading;
    if (sections[section].text == mukca_report_put_placements && r->data.n_sockets == 0)
        heading = "Position errors";
    char *figures = NULL;
    size_t size = 0;
    const mukca_page_figures page = {.page = open_memstream(&figures, &size)};
    if (!page.page) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the figures");
    mukca_status status = put_figures(&page, section, r, error);
    if (!mukca_file_close(page.page, &figures) && status == MUKCA_OK)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for the figures");
    if (status == MUKCA_OK && (size > 0 || !sections[section].figure)) {
        fprintf(list, "<li><a href=\"#%s\">%s</a></li>\n", id, heading);
        fprintf(out, "<section aria-labelledby=\"%s\">\n<h2 id=\"%s\">%s</h2>\n", id, id, heading);
        if (size > 0) fprintf(out, "<div class=\"figures\">\n%s</div>\n", figures);
        if (sections[section].text) sections[section].text(out, r);
        fputs("</section>\n", out);
    }
    free(figures);
    return status;
}

mukca_status mukca_report_write(FILE *out, const mukca_report *r, mukca_error *error)
{
    char *text = NULL;
    size_t size = 0;
    FILE *body = open_memstream(&text, &size); /* the list of sections precedes them */
    mukca_status status = MUKCA_OK;
    if (!body) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the page");
    mukca_page_begin(out, &(mukca_page_head){.robot = r->chain->robot,
                                             .kind = "calibration report",
                                             .from = r->chain->base,
                                             .to = r->chain->tip,
                                             .when = r->when});
    mukca_report_put_verdict(out, r);
    mukca_report_put_key_figures(out, r);
    fputs("<nav aria-label=\"Sections\"><ul>\n", out);
    for (int k = 0; k < SECTIONS && status == MUKCA_OK; k++)
        status = put_section(body, out, k, r, error);
    if (!mukca_file_close(body, &text) && status == MUKCA_OK)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for the page");
    if (status == MUKCA_OK) {
        fprintf(out, "</ul></nav>\n%s", text);
        mukca_page_end(out);
    }
    free(text);
    return status;
}

mukca_status mukca_report_write_figures(const char *directory, const char *format,
                                        const mukca_report *r, mukca_error *error)
{
    const mukca_page_figures files = {.directory = directory, .format = format};
    mukca_status status = MUKCA_OK;
    for (int k = 0; k < SECTIONS && status == MUKCA_OK; k++)
        status = put_figures(&files, k, r, error);
    return status;
}
