/* The report's page: its head, its sections in the order of reading, and where the figures go. */
#include "report/report.h"

#include <stdlib.h>
#include <string.h>

#include "mukca/version.h"
#include "report/parts.h"
#include "report/style.h"

/* px; figures from BROAD on take the whole width of the page, those above NARROW scroll on a
 * telephone */
enum { NARROW = 480, BROAD = 800 };

static void put_explanation(FILE *out, const mukca_report *r)
{
    (void)r;
    fputs(
        "<p>Consistency is the spread of the predicted ball centres of one socket; distortion is "
        "by "
        "how much the distance between two sockets is predicted wrongly.</p>\n",
        out);
}

static void put_causes(FILE *out, const mukca_report *r)
{
    report_put_causes(out, r);
    report_put_next_poses(out, r);
}

/* section, id, heading, and what stands below the figures */
static const struct {
    report_section section;
    const char *id, *heading;
    void (*before)(FILE *out, const mukca_report *r); /* the figures; or NULL */
    void (*after)(FILE *out, const mukca_report *r);  /* or NULL */
} sections[] = {
    {REPORT_GAP, "gap", "The gap and its causes", NULL, put_causes},
    {REPORT_PLACEMENTS, "placements", "Errors by placement", NULL, report_put_placements},
    {REPORT_TRAINING, "training", "Training", put_explanation, NULL},
    {REPORT_CENTRES, "centres", "Ball centres", NULL, NULL},
    {REPORT_MATRIX, "matrix", "Trained here, tested there", NULL, NULL},
    {REPORT_JOINTS, "joints", "Error by joint", NULL, report_put_untestable},
    {REPORT_ROWS, "rows", "Rows and faults of recording", NULL, report_put_faults},
    {REPORT_OFFSETS, "offsets", "Offsets", NULL, report_put_offsets},
};
enum { SECTIONS = sizeof sections / sizeof *sections };

/* The script of a figure, unless it is time to stop. */
static mukca_status draw(mukca_figure *figure, report_sheet *sheet, int k, int i,
                         const mukca_report *report, mukca_error *error)
{
    if (report->stop && report->stop(NULL))
        return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted; the page was not written");
    return report_draw(figure, sheet, &report_figures[k], i, report, error);
}

/* The figures of section k; with a NULL page only tells (in *any) whether there are some. */
static mukca_status put_figures(FILE *out, bool *any, report_section section,
                                const mukca_report *report, mukca_error *error)
{
    *any = false;
    for (int k = 0; k < report_n_figures; k++) {
        const int count =
            report_figures[k].section == section ? report_figures[k].count(report) : 0;
        if (count > 0 && out && !*any) fputs("<div class=\"figures\">\n", out);
        *any |= count > 0;
        for (int i = 0; out && i < count; i++) {
            report_sheet sheet;
            mukca_figure figure;
            mukca_status status = draw(&figure, &sheet, k, i, report, error);
            if (status != MUKCA_OK) return status;
            fprintf(out, "<figure%s>\n",
                    figure.width >= BROAD   ? " class=\"broad\""
                    : figure.width > NARROW ? " class=\"middling\""
                                            : "");
            status = mukca_plot_svg(out, &figure, sheet.text, error);
            fputs("<figcaption><strong>", out);
            mukca_html_escape(out, figure.title);
            fputs("</strong> ", out);
            mukca_html_escape(out, figure.description);
            fputs("</figcaption>\n</figure>\n", out);
            report_sheet_free(&sheet);
            if (status != MUKCA_OK) return status;
        }
    }
    if (out && *any) fputs("</div>\n", out);
    return MUKCA_OK;
}

mukca_status mukca_report_write(FILE *out, const mukca_report *report, mukca_error *error)
{
    bool shown[SECTIONS];
    for (int k = 0; k < SECTIONS; k++) {
        put_figures(NULL, &shown[k], sections[k].section, report, error);
        shown[k] |= sections[k].section == REPORT_GAP && report->diagnosis;
    }
    fputs(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<meta name=\"color-scheme\" content=\"light dark\">\n<title>",
        out);
    mukca_html_escape(out, report->chain->robot);
    fprintf(out,
            ": calibration report</title>\n<style>\n%s</style>\n</head>\n<body>\n<header>\n<h1>",
            report_style);
    mukca_html_escape(out, report->chain->robot);
    fputs(": calibration report</h1>\n<p>From <code>", out);
    mukca_html_escape(out, report->chain->base);
    fputs("</code> to <code>", out);
    mukca_html_escape(out, report->chain->tip);
    fprintf(out, "</code>, mukca %s, %s</p>\n</header>\n<main>\n", MUKCA_VERSION, report->when);
    report_put_verdict(out, report);
    fputs("<nav aria-label=\"Sections\"><ul>\n", out);
    for (int k = 0; k < SECTIONS; k++)
        if (shown[k])
            fprintf(out, "<li><a href=\"#%s\">%s</a></li>\n", sections[k].id, sections[k].heading);
    fputs("<li><a href=\"#provenance\">Provenance</a></li>\n</ul></nav>\n", out);
    for (int k = 0; k < SECTIONS; k++) {
        if (!shown[k]) continue;
        bool any;
        fprintf(out, "<section aria-labelledby=\"%s\">\n<h2 id=\"%s\">%s</h2>\n", sections[k].id,
                sections[k].id, sections[k].heading);
        if (sections[k].before) sections[k].before(out, report);
        const mukca_status status = put_figures(out, &any, sections[k].section, report, error);
        if (status != MUKCA_OK) return status;
        if (sections[k].after) sections[k].after(out, report);
        fputs("</section>\n", out);
    }
    fputs("<section aria-labelledby=\"provenance\">\n<h2 id=\"provenance\">Provenance</h2>\n", out);
    report_put_provenance(out, report);
    fputs("</section>\n</main>\n</body>\n</html>\n", out);
    return MUKCA_OK;
}

mukca_status mukca_report_write_figures(const char *directory, const char *format,
                                        const mukca_report *report, mukca_error *error)
{
    for (int k = 0; k < report_n_figures; k++) {
        const int count = report_figures[k].count(report);
        for (int i = 0; i < count; i++) {
            report_sheet sheet = {.text = NULL};
            mukca_figure figure = {.id = ""};
            char path[4096];
            mukca_status status = draw(&figure, &sheet, k, i, report, error);
            if (status != MUKCA_OK) return status;
            snprintf(path, sizeof path, "%s/%s.%s", directory, figure.id, format);
            status = mukca_plot_file(path, format, &figure, sheet.text, error);
            report_sheet_free(&sheet);
            if (status != MUKCA_OK) return status;
        }
    }
    return MUKCA_OK;
}
