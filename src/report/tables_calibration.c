/* Texts and tables of the calibration: key figures, placements, offsets, provenance. */
#include <math.h>

#include "report/html.h"
#include "report/tables.h"

static const double mm = 1e3;

/* ---- key figures ---- */

static void put_length(FILE *out, const char *label, double metres)
{
    if (isfinite(metres))
        fprintf(out, "<div><dt>%s</dt><dd>%#.3g <small>mm</small></dd></div>\n", label,
                metres * mm);
}

static void put_count(FILE *out, const char *label, int count)
{
    if (count > 0) fprintf(out, "<div><dt>%s</dt><dd>%d</dd></div>\n", label, count);
}

void mukca_report_put_key_figures(FILE *out, const mukca_report *r)
{
    const mukca_diagnosis *d = r->diagnosed.diagnosis;
    const bool test = r->test_scores.n > 0;
    const mukca_report_scores *scores = test ? &r->test_scores : &r->train_scores;
    fputs("<dl class=\"tiles\">\n", out);
    put_length(out, test ? "nominal, test data" : "nominal, training data",
               scores->nominal_mean.mae);
    put_length(out, test ? "calibrated, test data" : "calibrated, training data",
               scores->calibrated_mean.mae);
    put_length(out, "held out, geometry", d->geometry_m);
    if (d->n_causes > 0) put_length(out, "held out, with the causes", d->explained_m);
    put_length(out, "noise floor", d->noise_floor_m);
    put_count(out, "samples", r->data.n_rows);
    put_count(out, "placements", r->data.n_placements);
    if (r->fit)
        fprintf(out,
                "<div><dt>identifiable combinations</dt><dd>%d <small>of %d</small></dd></div>\n",
                r->fit->identification.rank, r->fit->parameters.n);
    fputs("</dl>\n", out);
}

/* ---- errors by placement ---- */

void mukca_report_put_placements(FILE *out, const mukca_report *r)
{
    const mukca_report_scores *lists[2] = {&r->train_scores, &r->test_scores};
    const mukca_dataset *data[2] = {r->train, r->test};
    mukca_html_table table = {
        .out = out,
        .columns =
            "placement|used for|#samples|#mean error, nominal|#mean error, calibrated|#rms, "
            "nominal|#rms, calibrated|#distortion, nominal|#distortion, calibrated"};
    mukca_html_table_begin(&table, "Errors by placement, mm");
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < lists[k]->n; i++) {
            const mukca_score *a = &lists[k]->nominal[i], *b = &lists[k]->calibrated[i];
            mukca_html_table_row(&table);
            mukca_html_table_text(
                &table, b->placement < 0 ? "poses" : data[k]->placements[b->placement].name);
            mukca_html_table_text(&table, k ? "test" : "training");
            mukca_html_table_number(&table, b->rows, 0);
            mukca_html_table_number(&table, a->mae * mm, 3);
            mukca_html_table_number(&table, b->mae * mm, 3);
            mukca_html_table_number(&table, a->std * mm, 3);
            mukca_html_table_number(&table, b->std * mm, 3);
            mukca_html_table_number(&table, a->distance_error * mm, 3);
            mukca_html_table_number(&table, b->distance_error * mm, 3);
        }
    mukca_html_table_end(&table);
}

/* ---- offsets ---- */

void mukca_report_put_offsets(FILE *out, const mukca_report *r)
{
    mukca_offset_row rows[MUKCA_MAX_OFFSET_ROWS];
    const int n = mukca_offsets_rows(rows, r->offsets, r->fitted);
    mukca_html_table table = {
        .out = out,
        .columns = "joint|parameter|unit|#nominal|#calibrated|#offset|#sigma|identifiable"};
    mukca_html_table_begin(&table,
                           "Offsets: calibrated = nominal + offset, in the URDF's origins; "
                           "sigma only where the data alone determine the parameter");
    for (int i = 0; i < n; i++) {
        const mukca_offset_row *row = &rows[i];
        mukca_html_table_row(&table);
        mukca_html_table_text(&table, row->joint);
        mukca_html_table_text(&table, row->parameter);
        mukca_html_table_text(&table, row->unit);
        mukca_html_table_number(&table, row->nominal, 6);
        mukca_html_table_number(&table, row->calibrated, 6);
        mukca_html_table_number(&table, row->offset, 6);
        mukca_html_table_number(&table, row->sigma, 6);
        mukca_html_table_text(&table, row->identifiable ? "yes" : "no");
    }
    mukca_html_table_end(&table);
}

/* ---- provenance ---- */

void mukca_report_put_provenance(FILE *out, const mukca_report *r)
{
    fputs("<p>Made by <code>", out);
    mukca_html_escape(out, r->command);
    fprintf(out, "</code> at %s.", r->when);
    if (r->fit)
        fprintf(out, " Solver %s: %d evaluations, %d iterations.", r->solver,
                r->fit->outcome.evaluations, r->fit->outcome.iterations);
    fputs("</p>\n", out);
    mukca_html_table table = {.out = out, .columns = "file|SHA-256"};
    mukca_html_table_begin(&table, "Files read");
    for (int i = 0; i < r->n_files; i++) {
        mukca_html_table_row(&table);
        mukca_html_table_text(&table, r->files[i].path);
        mukca_html_table_text(&table, r->files[i].sha256);
    }
    mukca_html_table_end(&table);
}
