/* Figures of the remaining error: by joint and by sample. */
#include <math.h>
#include <string.h>

#include "base/text.h"
#include "report/report.h"

static const double mm = MUKCA_REPORT_MM;

/* ---- error over the angle of one joint ---- */

bool mukca_report_joints(mukca_plot *plot, const void *content, int index)
{
    const mukca_report *r = content;
    if (index >= r->chain->n_joints) return false;
    const int n = r->chain->n_joints, rows = r->train->n_rows;
    const mukca_element *e = &r->chain->element[r->chain->joint_element[index]];
    const bool turns = e->type != MUKCA_PRISMATIC, causes = r->offsets->n_effects > 0;
    const char *coordinate = turns ? "angle" : "position";
    const double unit = turns ? 180 / M_PI : mm;
    mukca_text description = MUKCA_TEXT(plot->words);
    snprintf(plot->id, sizeof plot->id, "joint-%d", index + 1);
    snprintf(plot->title, sizeof plot->title, "Error over the %s of %s", coordinate, e->name);
    snprintf(plot->label[0], sizeof *plot->label, "%s, %s", coordinate, turns ? "deg" : "mm");
    snprintf(plot->label[1], sizeof *plot->label, "error along its motion, mm");
    plot->width = MUKCA_PLOT_HALF;
    plot->height = 320;
    plot->brief = true;
    plot->key[MUKCA_PLOT_AFTER] = causes ? "with its causes" : "calibrated";
    plot->key[MUKCA_PLOT_BEFORE] = causes ? "without them" : NULL;
    for (int m = causes ? MUKCA_RIGID : MUKCA_CALIBRATED; m <= MUKCA_CALIBRATED; m++)
        for (int k = index; k < n * rows; k += n) {
            const double point[2] = {r->train->q[k] * unit, r->joint_error[m][k] * mm};
            mukca_plot_add(plot, m == MUKCA_RIGID ? MUKCA_PLOT_BEFORE : MUKCA_PLOT_AFTER, point,
                           NAN, NAN);
        }
    mukca_text_put(
        &description,
        "The part of each sample's error along which %s moves the %s, over the joint's %s: "
        "%.3f mm rms calibrated",
        e->name, r->train->n_sockets > 0 ? "ball" : "target", coordinate,
        mukca_report_joint_rms(r, MUKCA_CALIBRATED, index) * mm);
    if (causes)
        mukca_text_put(&description, ", %.3f mm without the causes of the table",
                       mukca_report_joint_rms(r, MUKCA_RIGID, index) * mm);
    mukca_text_put(&description, ".");
    return true;
}

/* ---- error of each sample in recording order, faults marked ---- */

/* Mark the start of each placement by its name. */
static void mark_placements(mukca_plot *plot, const mukca_dataset *data)
{
    for (int k = 0; k < data->n_rows; k++) {
        const int p = mukca_dataset_placement(data, k);
        if (p >= 0 && (k == 0 || p != mukca_dataset_placement(data, k - 1)))
            mukca_plot_name(plot, k + 1, data->placements[p].name);
    }
}

bool mukca_report_samples(mukca_plot *plot, const void *content, int index)
{
    const mukca_report *r = content;
    const mukca_dataset *data = r->train;
    const mukca_diagnosis *d = r->diagnosed.diagnosis;
    const bool sockets = data->n_sockets > 0;
    double most = 0;
    if (index > 0) return false;
    mukca_text description = MUKCA_TEXT(plot->words);
    snprintf(plot->id, sizeof plot->id, "samples");
    snprintf(plot->title, sizeof plot->title, "Error of each training sample, in recording order");
    snprintf(plot->label[0], sizeof *plot->label, "sample");
    snprintf(plot->label[1], sizeof *plot->label, "%s, mm",
             sockets ? "consistency error" : "distance from the measured position");
    plot->width = MUKCA_PLOT_FULL;
    plot->height = 360;
    plot->from_zero = true;
    plot->key[MUKCA_PLOT_AFTER] = sockets ? "first socket" : NULL;
    plot->key[MUKCA_PLOT_THIRD] = sockets ? "second socket" : NULL;
    plot->key[MUKCA_PLOT_BEFORE] = d->n_faults > 0 ? "recording fault" : NULL;
    for (int k = 0; k < data->n_rows; k++) {
        const double error = mukca_norm3(r->residual[MUKCA_CALIBRATED] + 3 * k) * mm;
        mukca_plot_add(plot, data->socket[k] % 2 > 0 ? MUKCA_PLOT_THIRD : MUKCA_PLOT_AFTER,
                       (double[]){k + 1, error}, NAN, NAN);
        most = fmax(most, error);
    }
    for (int i = 0; i < d->n_faults; i++) {
        const int row = d->faults[i].data_row;
        const double error = mukca_norm3(r->residual[MUKCA_CALIBRATED] + 3 * row) * mm;
        mukca_plot_add(plot, MUKCA_PLOT_BEFORE, (double[]){row + 1, error}, NAN, NAN);
    }
    mark_placements(plot, data);
    mukca_text_put(&description,
                   "%d samples after calibration; largest error %.3f mm; %d recording "
                   "fault%s marked.",
                   data->n_rows, most, d->n_faults, d->n_faults == 1 ? "" : "s");
    return true;
}
