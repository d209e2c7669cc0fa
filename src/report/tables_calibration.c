/* Texts, tables and figures of the calibration: accuracy, errors, offsets, files. */
#include <math.h>
#include <string.h>

#include "base/text.h"
#include "report/report.h"

#define put mukca_wording_put /* short for this file */

static const double mm = 1e3; /* per m */

/* ---- accuracy ---- */

void mukca_report_put_accuracy(FILE *out, const void *content)
{
    const mukca_report *r = content;
    const mukca_acceptance *a = &r->offsets->acceptance;
    const bool factory = r->fitted->kinematics_sha256[0] != '\0';
    char tip[MUKCA_ACCEPTANCE_SENTENCE] = "", use[MUKCA_ACCEPTANCE_SENTENCE] = "";
    if (!a->given) return;
    if (a->accepted) mukca_acceptance_put_tip(&(mukca_text)MUKCA_TEXT(tip), a, factory);
    mukca_acceptance_put_use(&(mukca_text)MUKCA_TEXT(use), a, factory);
    if (*tip) {
        fputs("<p><strong>Accuracy of the tip:</strong> ", out);
        mukca_html_escape(out, tip);
        fputs(".</p>\n", out);
    }
    fprintf(out, "<p class=\"verdict %s use\"><strong>Use the result?</strong> ",
            a->accepted ? "named" : "untestable");
    mukca_html_sentence(out, "", use, ".</p>\n");
}

/* ---- errors by joint ---- */

/* Component of a sample's residual along the ball's motion by joint j, r . J_j / |J_j|, mm. */
static double joint_error(const mukca_report *r, int model, int row, int j)
{
    const int n = r->train->n_joints;
    const double *tip = r->evaluation[model].tips[row].p,
                 *centre = mukca_evaluation_centre(&r->evaluation[model], r->train, row);
    double J[6 * MUKCA_MAX_JOINTS], dot = 0, square = 0;
    mukca_fk_jacobian(J, NULL, &r->geometry, r->train->q + row * n, NULL);
    for (int k = 0; k < 3; k++) {
        dot += (tip[k] - centre[k]) * J[k * n + j];
        square += J[k * n + j] * J[k * n + j];
    }
    /* below 1 um per rad the joint has no effect on the ball */
    return square > 1e-12 && isfinite(dot) ? dot / sqrt(square) * mm : 0;
}

/* Root of their mean square over all samples, mm. */
static double joint_rms(const mukca_report *r, int model, int j)
{
    const int rows = r->train->n_rows;
    double sum = 0;
    for (int i = 0; i < rows; i++) sum += pow(joint_error(r, model, i, j), 2) / rows;
    return sqrt(sum);
}

/* The remaining error over the angle of a joint. */
static void put_joint(FILE *out, const mukca_report *r, int index)
{
    const int n = r->chain->n_joints;
    const mukca_element *e = &r->chain->element[r->chain->joint_element[index]];
    const bool turns = e->type != MUKCA_PRISMATIC, causes = r->offsets->n_effects > 0;
    const char *coordinate = turns ? "angle" : "position";
    const double unit = turns ? 180 / M_PI : mm;
    mukca_plot plot = {
        .id = put(MUKCA_WORDS, "joint-%d", index + 1),
        .title = put(MUKCA_WORDS, "Error over the %s of %s", coordinate, e->name),
        .label = {turns ? "angle, deg" : "position, mm", "error along its motion, mm"},
        .words = put(MUKCA_WORDS,
                     "The part of each sample's error along which %s moves the %s, over the "
                     "joint's %s: %.3f mm rms calibrated.",
                     e->name, r->train->n_sockets > 0 ? "ball" : "target", coordinate,
                     joint_rms(r, MUKCA_CALIBRATED, index)),
        .key = {[MUKCA_PLOT_AFTER] = causes ? "with its causes" : "calibrated",
                [MUKCA_PLOT_BEFORE] = causes ? "without them" : NULL},
        .points = r->points};
    for (int m = causes ? MUKCA_RIGID : MUKCA_CALIBRATED; m <= MUKCA_CALIBRATED; m++)
        for (int i = 0; i < r->train->n_rows; i++)
            plot.points[plot.n_points++] = (mukca_plot_point){
                m == MUKCA_RIGID ? MUKCA_PLOT_BEFORE : MUKCA_PLOT_AFTER,
                {r->train->q[i * n + index] * unit, joint_error(r, m, i, index)}};
    mukca_plot_put(out, &plot);
}

void mukca_report_put_joints(FILE *out, const void *content)
{
    const mukca_report *r = content;
    const bool causes = r->offsets->n_effects > 0;
    fputs("<div class=\"figures\">\n", out);
    for (int j = 0; j < r->train->n_joints; j++) put_joint(out, r, j);
    fputs("</div>\n", out);
    mukca_html_table table = {
        .out = out,
        .caption = "Error along the motion by each joint, mm rms over the training samples",
        .columns = causes ? "joint|#nominal|#calibrated|#calibrated, without its causes"
                          : "joint|#nominal|#calibrated"};
    for (int j = 0; j < r->train->n_joints; j++)
        mukca_html_row(&table, causes ? "%s\t%.3f\t%.3f\t%.3f" : "%s\t%.3f\t%.3f",
                       mukca_chain_joint_name(r->chain, j), joint_rms(r, MUKCA_NOMINAL, j),
                       joint_rms(r, MUKCA_CALIBRATED, j), joint_rms(r, MUKCA_RIGID, j));
    mukca_html_table_end(&table);
}

/* ---- errors by placement ---- */

void mukca_report_put_placements(FILE *out, const void *content)
{
    const mukca_report *r = content;
    const bool sockets = r->train->n_sockets > 0;
    mukca_html_table table = {
        .out = out,
        .caption =
            sockets
                ? "Errors of the table of offsets by placement, mm (as mukca evaluate prints them)"
                : "Position errors of the table of offsets, mm (as mukca evaluate prints them)",
        .columns = sockets ? "placement|#error nominal|#error calibrated|#distortion "
                             "nominal|#distortion calibrated"
                           : "data|#error nominal|#error calibrated"};
    for (int set = 0; set < 2; set++)
        for (int i = 0; i < r->n_scores[set]; i++) {
            const mukca_score *a = &r->score[set][0][i], *b = &r->score[set][1][i];
            const mukca_placement *placements = (set ? r->test : r->train)->placements;
            mukca_html_row(&table,
                           sockets ? "%s (%s, %d samples)\t%.3f\t%.3f\t%.3f\t%.3f"
                                   : "%s (%s, %d samples)\t%.3f\t%.3f",
                           b->placement < 0 ? "poses" : placements[b->placement].name,
                           set ? "test" : "training", b->rows, a->mae * mm, b->mae * mm,
                           a->distance_error * mm, b->distance_error * mm);
        }
    mukca_html_table_end(&table);
    fputs(sockets ? "<p>Error: mean distance of the predicted ball centres of one socket from "
                    "their mean. Distortion: error of the predicted distance between two sockets. "
                    "Training errors are those of the data that were fitted.</p>\n"
                  : "<p>Error: mean distance of the predicted from the measured position.</p>\n",
          out);
    if (r->offsets->n_effects > 0)
        fputs(
            "<p>The table has one coefficient per cause; the diagnosis above also fits the link "
            "masses, and its errors may differ a little.</p>\n",
            out);
}

/* ---- the result ---- */

void mukca_report_put_offsets(FILE *out, const void *content)
{
    const mukca_report *r = content;
    mukca_html_table table = {.out = out,
                              .caption =
                                  "Parameters: calibrated = nominal + offset, in the URDF's "
                                  "origins; sigma: standard error; in brackets: not identifiable",
                              .style = "parameters",
                              .columns = "parameter|#nominal|#offset|#sigma"};
    for (int i = 0; i < r->n_offsets; i++) {
        const mukca_offset_row *row = &r->offset[i];
        const bool elastic = strcmp(row->unit, "rad/(N*m)") == 0;
        const double factor = elastic ? 1e6 : mm;
        const bool plain = strcmp(row->term, "-") == 0;
        mukca_html_row(&table, "%s%s %s%s%s, %s%s%s\t%.3f\t%.3f\t%.3f",
                       row->identifiable ? "" : "(", strcmp(row->joint, "-") ? row->joint : "arm",
                       row->parameter, plain ? "" : " ", plain ? "" : row->term,
                       elastic ? "u" : "m", row->unit, row->identifiable ? "" : ")",
                       row->nominal * factor, row->offset * factor, row->sigma * factor);
    }
    mukca_html_table_end(&table);
}
