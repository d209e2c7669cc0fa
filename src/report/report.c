/* The report's page: its head, its sections in the order of reading, and where the figures go. */
#include "report/report.h"

#include "mukca/version.h"
#include "report/figures.h"
#include "report/html.h"
#include "report/style.h"
#include "report/tables.h"

static void put_explanation(FILE *out, const mukca_report *r)
{
    (void)r;
    fputs(
        "<p>Consistency error: distance of the predicted ball centres of one socket from their "
        "mean. Distortion: error of the predicted distance between two sockets.</p>\n",
        out);
}

/* In the order of reading; `after` follows the figures, may be NULL. */
static const struct {
    mukca_report_section section;
    const char *id, *heading;
    void (*after)(FILE *out, const mukca_report *r);
} sections[] = {
    {MUKCA_SECTION_CAUSES, "causes", "Remaining error and its causes", mukca_report_put_causes},
    {MUKCA_SECTION_PLACEMENTS, "placements", "Errors by placement", mukca_report_put_placements},
    {MUKCA_SECTION_JOINTS, "joints", "Errors by joint", NULL},
    {MUKCA_SECTION_LIMITS, "limits", "Detection limits", mukca_report_put_limits},
    {MUKCA_SECTION_SAMPLES, "samples", "Samples and recording faults", mukca_report_put_faults},
    {MUKCA_SECTION_CENTRES, "centres", "Predicted ball centres", NULL},
    {MUKCA_SECTION_CONVERGENCE, "convergence", "Convergence", put_explanation},
    {MUKCA_SECTION_GENERALISATION, "generalisation", "Generalisation to other placements", NULL},
    {MUKCA_SECTION_OFFSETS, "offsets", "Offsets", mukca_report_put_offsets},
};
enum { SECTIONS = sizeof sections / sizeof *sections };

/* Is there anything to show? */
static bool shown(int section, const mukca_report *r)
{
    if (sections[section].section == MUKCA_SECTION_LIMITS) return r->diagnosed.diagnosis->n_tested;
    for (const mukca_report_figure *f = mukca_report_figures; f->draw; f++)
        if (f->section == sections[section].section && f->count(r) > 0) return true;
    return false;
}

static mukca_status put_figure(FILE *out, const mukca_report_figure *kind, int index,
                               const mukca_report *r, mukca_error *error)
{
    mukca_sheet sheet;
    mukca_figure figure;
    mukca_status status = mukca_report_draw(&figure, &sheet, kind, index, r, error);
    if (status != MUKCA_OK) goto out;
    fputs(figure.width > MUKCA_SHEET_HALF ? "<figure class=\"broad\">\n" : "<figure>\n", out);
    status = mukca_plot_svg(out, &figure, sheet.text, error);
    fputs("<figcaption><strong>", out);
    mukca_html_escape(out, figure.title);
    fputs("</strong> ", out);
    mukca_html_escape(out, figure.description);
    fputs("</figcaption>\n</figure>\n", out);
out:
    mukca_sheet_free(&sheet);
    return status;
}

static mukca_status put_section(FILE *out, int section, const mukca_report *r, mukca_error *error)
{
    fprintf(out,
            "<section aria-labelledby=\"%s\">\n<h2 id=\"%s\">%s</h2>\n<div class=\"figures\">\n",
            sections[section].id, sections[section].id, sections[section].heading);
    for (const mukca_report_figure *f = mukca_report_figures; f->draw; f++) {
        if (f->section != sections[section].section) continue;
        for (int i = 0, n = f->count(r); i < n; i++) {
            const mukca_status status = put_figure(out, f, i, r, error);
            if (status != MUKCA_OK) return status;
        }
    }
    fputs("</div>\n", out);
    if (sections[section].after) sections[section].after(out, r);
    fputs("</section>\n", out);
    return MUKCA_OK;
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
    fputs(": calibration report</h1>\n<p>From <code>", out);
    mukca_html_escape(out, r->chain->base);
    fputs("</code> to <code>", out);
    mukca_html_escape(out, r->chain->tip);
    fprintf(out, "</code>, mukca %s, %s</p>\n</header>\n<main>\n", MUKCA_VERSION, r->when);
}

mukca_status mukca_report_write(FILE *out, const mukca_report *r, mukca_error *error)
{
    put_head(out, r);
    mukca_report_put_verdict(out, r);
    mukca_report_put_key_figures(out, r);
    fputs("<nav aria-label=\"Sections\"><ul>\n", out);
    for (int k = 0; k < SECTIONS; k++)
        if (shown(k, r))
            fprintf(out, "<li><a href=\"#%s\">%s</a></li>\n", sections[k].id, sections[k].heading);
    fputs("<li><a href=\"#provenance\">Provenance</a></li>\n</ul></nav>\n", out);
    for (int k = 0; k < SECTIONS; k++) {
        const mukca_status status = shown(k, r) ? put_section(out, k, r, error) : MUKCA_OK;
        if (status != MUKCA_OK) return status;
    }
    fputs("<section aria-labelledby=\"provenance\">\n<h2 id=\"provenance\">Provenance</h2>\n", out);
    mukca_report_put_provenance(out, r);
    fputs("</section>\n</main>\n</body>\n</html>\n", out);
    return MUKCA_OK;
}

mukca_status mukca_report_write_figures(const char *directory, const char *format,
                                        const mukca_report *r, mukca_error *error)
{
    for (const mukca_report_figure *f = mukca_report_figures; f->draw; f++)
        for (int i = 0, n = f->count(r); i < n; i++) {
            mukca_sheet sheet;
            mukca_figure figure;
            char path[4096];
            mukca_status status = mukca_report_draw(&figure, &sheet, f, i, r, error);
            if (status == MUKCA_OK) {
                snprintf(path, sizeof path, "%s/%s.%s", directory, figure.id, format);
                status = mukca_plot_file(path, format, &figure, sheet.text, error);
            }
            mukca_sheet_free(&sheet);
            if (status != MUKCA_OK) return status;
        }
    return MUKCA_OK;
}
