/* Texts and tables of the calibration: key figures, placements, offsets, provenance. */
#include <math.h>

#include "report/html.h"
#include "report/parts.h"

static void put_length(FILE *out, const char *label, double metres)
{
    if (isfinite(metres))
        fprintf(out, "<div><dt>%s</dt><dd>%#.3g <small>mm</small></dd></div>\n", label,
                metres * MUKCA_REPORT_MM);
}

static void put_count(FILE *out, const char *label, int count)
{
    if (count > 0) fprintf(out, "<div><dt>%s</dt><dd>%d</dd></div>\n", label, count);
}

void mukca_report_put_key_figures(FILE *out, const mukca_report *r)
{
    const mukca_diagnosis *d = r->diagnosed.diagnosis;
    const bool test = r->test->n_rows > 0;
    fputs("<dl class=\"tiles\">\n", out);
    put_length(out, test ? "nominal, test data" : "nominal, training data", r->nominal_m);
    put_length(out, test ? "calibrated, test data" : "calibrated, training data", r->calibrated_m);
    put_length(out, "held out, geometry", d->geometry_m);
    if (d->n_causes > 0) put_length(out, "held out, with the causes", d->explained_m);
    put_length(out, "noise floor", d->noise_floor_m);
    put_count(out, "samples", r->data.n_rows);
    if (r->data.n_placements > 0) put_count(out, "placements", r->data.n_placements);
    if (r->fit)
        fprintf(out,
                "<div><dt>identifiable combinations</dt><dd>%d <small>of %d</small></dd></div>\n",
                r->fit->identification.rank, r->fit->parameters.n);
    fputs("</dl>\n", out);
}

void mukca_report_put_placements(FILE *out, const void *content)
{
    const mukca_report *r = content;
    const bool sockets = r->data.n_sockets > 0;
    mukca_html_table table = {
        .out = out,
        .caption = sockets ? "Errors by placement, mm" : "Position errors, mm",
        .columns = sockets ? "placement|used for|#samples|#mean error, nominal|#mean error, "
                             "calibrated|#rms, nominal|#rms, calibrated|#distortion, "
                             "nominal|#distortion, calibrated"
                           : "data|used for|#samples|#mean error, nominal|#mean error, "
                             "calibrated|#rms, nominal|#rms, calibrated"};
    const double mm = MUKCA_REPORT_MM;
    for (int i = 0; i < r->n_scores; i++) {
        const mukca_score *a = &r->scores[i].nominal, *b = &r->scores[i].calibrated;
        if (!sockets) {
            mukca_html_row(&table, "%s\t%s\t%d\t%.3f\t%.3f\t%.3f\t%.3f", r->scores[i].placement,
                           r->scores[i].test ? "test" : "training", b->rows, a->mae * mm,
                           b->mae * mm, a->std * mm, b->std * mm);
            continue;
        }
        mukca_html_row(&table, "%s\t%s\t%d\t%.3f\t%.3f\t%.3f\t%.3f\t%.3f\t%.3f",
                       r->scores[i].placement, r->scores[i].test ? "test" : "training", b->rows,
                       a->mae * mm, b->mae * mm, a->std * mm, b->std * mm, a->distance_error * mm,
                       b->distance_error * mm);
    }
    mukca_html_table_end(&table);
    fputs(sockets ? "<p>Consistency error (mean, rms): distance of the predicted ball centres of "
                    "one socket from their mean. Distortion: error of the predicted distance "
                    "between two sockets.</p>\n"
                  : "<p>Error of a pose: distance of the predicted from the measured "
                    "position.</p>\n",
          out);
}

void mukca_report_put_offsets(FILE *out, const void *content)
{
    const mukca_report *r = content;
    char verdict[MUKCA_ACCEPTANCE_SENTENCE];
    mukca_acceptance_sentence(verdict, &r->offsets->acceptance,
                              r->fitted->kinematics_sha256[0] != '\0');
    fputs("<p>Verdict of the table: ", out);
    mukca_html_element(out, "strong", verdict);
    fputs(".</p>\n", out);
    mukca_html_table table = {
        .out = out,
        .caption =
            "Offsets: calibrated = nominal + offset, in the URDF's origins; sigma only where the "
            "data alone determine the parameter",
        .columns = "joint|parameter|unit|#nominal|#calibrated|#offset|#sigma|identifiable"};
    for (int i = 0; i < r->n_offsets; i++) {
        const mukca_offset_row *row = &r->offset[i];
        mukca_html_row(&table, "%s\t%s\t%s\t%.6f\t%.6f\t%.6f\t%.6f\t%s", row->joint, row->parameter,
                       row->unit, row->nominal, row->calibrated, row->offset, row->sigma,
                       row->identifiable ? "yes" : "no");
    }
    mukca_html_table_end(&table);
}

void mukca_report_put_provenance(FILE *out, const void *content)
{
    const mukca_report *r = content;
    fputs("<p>Made by ", out);
    mukca_html_element(out, "code", r->command);
    fprintf(out, " at %s.", r->when);
    if (r->fit)
        fprintf(out, " Solver %s: %d evaluations, %d iterations.", r->solver,
                r->fit->outcome.evaluations, r->fit->outcome.iterations);
    fputs("</p>\n", out);
    mukca_html_table table = {.out = out, .caption = "Files read", .columns = "file|SHA-256"};
    for (int i = 0; i < r->n_files; i++)
        mukca_html_row(&table, "%s\t%s", r->files[i].path, r->files[i].sha256);
    mukca_html_table_end(&table);
}
