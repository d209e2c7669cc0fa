/* Figures of the remaining error: by joint and by sample. */
#include <math.h>
#include <string.h>

#include "report/parts.h"

static const double mm = MUKCA_REPORT_MM;

/* ---- error over the angle of one joint ---- */

bool mukca_report_joints(mukca_plot *plot, const void *content, int index)
{
    const mukca_report *r = content;
    if (index >= r->chain->n_joints) return false;
    const int n = r->chain->n_joints, rows = r->data.n_rows;
    const mukca_element *e = &r->chain->element[r->chain->joint_element[index]];
    const bool turns = e->type != MUKCA_PRISMATIC;
    const char *coordinate = turns ? "angle" : "position";
    const double unit = turns ? 180 / M_PI : mm;
    char id[64], title[160];
    const bool causes = r->offsets->n_effects > 0;
    snprintf(id, sizeof id, "joint-%d", index + 1);
    snprintf(title, sizeof title, "Error over the %s of %s", coordinate, e->name);
    mukca_plot_begin(plot, id, title, MUKCA_PLOT_HALF, 320);
    plot->brief = true;
    FILE *s = plot->script;
    fputs("$d << EOD\n", s);
    for (int k = 0; k < rows; k++)
        fprintf(s, "%.3f %.5g %.5g\n", r->data.q[k * n + index] * unit,
                r->joint_error[MUKCA_RIGID][k * n + index] * mm,
                r->joint_error[MUKCA_CALIBRATED][k * n + index] * mm);
    fprintf(s,
            "EOD\nset xlabel '%s, %s'\nset ylabel 'error along its motion, mm' offset 1,0\nset "
            "xzeroaxis lc rgb 'black' lw 0.6\nplot ",
            coordinate, turns ? "deg" : "mm");
    if (causes)
        fputs("$d using 1:2 with points lc rgb " PLOT_BEFORE
              " pt 6 ps 0.5 title 'without its causes', ",
              s);
    fprintf(s, "$d using 1:3 with points lc rgb " PLOT_AFTER " pt 7 ps 0.4 title '%s'\n",
            causes ? "with them" : "calibrated");
    fprintf(plot->description,
            "The part of each sample's error along which %s moves the %s, over the joint's %s: "
            "%.3f mm rms calibrated",
            e->name, r->data.n_sockets > 0 ? "ball" : "target", coordinate,
            mukca_report_joint_rms(r, MUKCA_CALIBRATED, index) * mm);
    if (causes)
        fprintf(plot->description, ", %.3f mm without the causes of the table",
                mukca_report_joint_rms(r, MUKCA_RIGID, index) * mm);
    fprintf(plot->description, ".");
    return true;
}

/* ---- error of each sample in recording order, faults marked ---- */

/* Mark the start of each placement by a line and its name. */
static void mark_placements(mukca_plot *plot, const mukca_dataset *data)
{
    for (int k = 0; k < data->n_rows; k++) {
        const int p = mukca_dataset_placement(data, k);
        if (p < 0 || (k > 0 && p == mukca_dataset_placement(data, k - 1))) continue;
        fprintf(plot->script,
                "set arrow from first %g, graph 0 to first %g, graph 1 nohead lc rgb 'gray' "
                "lw 0.8\n",
                k + 0.5, k + 0.5);
        mukca_plot_label(plot, data->placements[p].name,
                         "at first %g, graph 0.99 left rotate by -90 offset 0.7, 0", k + 0.5);
    }
}

bool mukca_report_samples(mukca_plot *plot, const void *content, int index)
{
    const mukca_report *r = content;
    const mukca_dataset *data = &r->data;
    const bool sockets = data->n_sockets > 0, faults = r->diagnosed.diagnosis->n_faults > 0;
    double most = 0;
    if (index > 0) return false;
    mukca_plot_begin(plot, "samples", "Error of each sample, in recording order", MUKCA_PLOT_FULL,
                     360);
    FILE *s = plot->script;
    fputs("$d << EOD\n", s);
    for (int k = 0; k < data->n_rows; k++) {
        const double error = mukca_norm3(r->residual[MUKCA_CALIBRATED] + 3 * k) * mm;
        if (!isfinite(error)) continue;
        fprintf(s, data->socket[k] % 2 > 0 ? "%d NaN %.5g\n" : "%d %.5g NaN\n", k + 1, error);
        most = fmax(most, error);
    }
    fputs("EOD\n$f << EOD\n", s);
    for (int i = 0; i < r->diagnosed.diagnosis->n_faults; i++) {
        const int row = r->diagnosed.diagnosis->faults[i].data_row;
        fprintf(s, "%d %.5g\n", row + 1, mukca_norm3(r->residual[MUKCA_CALIBRATED] + 3 * row) * mm);
    }
    fputs("EOD\n", s);
    mark_placements(plot, data);
    fprintf(s,
            "set xrange [0:%d]\nset yrange [0:%g]\nset xlabel 'sample'\n"
            "set ylabel '%s, mm' offset 1,0\n"
            "plot $d using 1:2 with points lc rgb " PLOT_AFTER " pt 7 ps 0.5 %s%s%s\n",
            data->n_rows + 1, most > 0 ? 1.15 * most : 1,
            sockets ? "consistency error" : "distance from the measured position",
            sockets ? "title 'first socket'" : "notitle",
            sockets ? ", $d using 1:3 with points lc rgb " PLOT_THIRD
                      " pt 9 ps 0.5 title 'second socket'"
                    : "",
            faults ? ", $f using 1:2 with points lc rgb " PLOT_BEFORE
                     " pt 2 ps 1.6 lw 2 title 'recording fault'"
                   : "");
    fprintf(plot->description,
            "%d samples after calibration; largest error %.3f mm; %d recording "
            "fault%s marked.",
            data->n_rows, most, r->diagnosed.diagnosis->n_faults,
            r->diagnosed.diagnosis->n_faults == 1 ? "" : "s");
    return true;
}
