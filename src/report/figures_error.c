/* Figures of the remaining error: by model, by joint and by sample. */
#include <math.h>
#include <string.h>

#include "report/parts.h"

static const double mm = MUKCA_REPORT_MM;

/* ---- held-out error by model ---- */

enum { MAX_RUNGS = MUKCA_MAX_CAUSES + 5 };

typedef struct {
    char name[200];
    double value, low, high; /* m */
} rung;

/* Append a bar with the interval of `held_out` (NULL: none), unless its value is unknown. */
static void add_rung(rung *rungs, int *n, const char *name, double value,
                     const mukca_shrink *held_out)
{
    if (*n >= MAX_RUNGS || !isfinite(value)) return;
    rung *x = &rungs[(*n)++];
    *x = (rung){.value = value, .low = value, .high = value};
    snprintf(x->name, sizeof x->name, "%s", name);
    if (held_out && isfinite(held_out->low_percent) && isfinite(held_out->high_percent)) {
        x->low = held_out->before_m * (1 - held_out->high_percent / 100);
        x->high = held_out->before_m * (1 - held_out->low_percent / 100);
    }
}

static int collect_rungs(rung rungs[MAX_RUNGS], const mukca_report *r)
{
    const mukca_diagnosis *d = r->diagnosed.diagnosis;
    int n = 0;
    add_rung(rungs, &n, "nominal model", d->nominal_m, NULL);
    add_rung(rungs, &n, "calibrated geometry", d->geometry_m, NULL);
    if (d->n_faults > 0)
        add_rung(rungs, &n, "geometry, faulty samples excluded", d->faults_excused_m, NULL);
    for (int i = 0; i < d->n_causes; i++) {
        char name[MUKCA_WORDING + 16], cause[MUKCA_WORDING];
        const mukca_shrink *held_out = &d->causes[i].held_out;
        mukca_wording_cause(cause, &d->causes[i], &r->diagnosed);
        snprintf(name, sizeof name, "geometry and %s", cause);
        add_rung(rungs, &n, name, held_out->after_m, held_out);
    }
    if (d->n_causes > 1)
        add_rung(rungs, &n, "geometry and all causes", d->held_out.after_m, &d->held_out);
    if (d->noise_floor_m > 0) add_rung(rungs, &n, "noise floor", d->noise_floor_m, NULL);
    return n;
}

bool mukca_report_ladder(mukca_plot *plot, const void *content, int index)
{
    const mukca_report *r = content;
    if (index > 0 || !isfinite(r->diagnosed.diagnosis->geometry_m)) return false;
    rung rungs[MAX_RUNGS];
    const int n = collect_rungs(rungs, r);
    if (n == 0) return false;
    const double floor = r->diagnosed.diagnosis->noise_floor_m;
    double most = 0;
    for (int k = 1; k < n; k++) most = fmax(most, fmax(rungs[k].value, rungs[k].high));
    /* A nominal error that would compress the other bars is drawn as an arrow at the edge. */
    const double edge = 1.25 * most * mm, nominal = rungs[0].value * mm;
    const bool beyond = nominal > edge;
    mukca_plot_begin(plot, "error-steps", "Held-out error, step by step", MUKCA_PLOT_HALF,
                     90 + 42 * n);
    FILE *s = plot->script;
    fputs("$d << EOD\n", s);
    for (int k = beyond; k < n; k++)
        fprintf(s, "%d %.6g %.6g %.6g\n", n - k, rungs[k].value * mm, rungs[k].low * mm,
                rungs[k].high * mm);
    fprintf(s,
            "EOD\nunset ytics\nset border 1\nset yrange [0.5:%g]\nset xrange [0:%g]\n"
            "set lmargin 2\nset rmargin 3\nset tmargin 2\n"
            "set xlabel 'mean held-out error, mm'\n",
            n + 0.8, edge);
    for (int k = 0; k < n; k++) mukca_plot_label(plot, rungs[k].name, MUKCA_PLOT_ABOVE, n - k);
    if (beyond)
        fprintf(s,
                "set arrow from first 0, %d to first %g, %d linecolor rgb " PLOT_BEFORE
                " linewidth 2\nset label '%#.3g ' at first %g, %d right offset 0, 0.75\n",
                n, edge, n, nominal, edge, n);
    if (floor > 0)
        fprintf(s,
                "set arrow from first %g, graph 0 to first %g, graph 1 nohead back linecolor "
                "'gray' dashtype 2\n",
                floor * mm, floor * mm);
    fputs("plot $d using (0):1:2:(0) with vectors nohead lc rgb " PLOT_AFTER
          " lw 2 notitle, $d using 2:1 with points lc rgb " PLOT_AFTER
          " pt 7 notitle, $d using 2:1:3:4 with xerrorbars lc rgb " PLOT_AFTER
          " pt 7 ps 0 lw 1.5 notitle, "
          "$d using 4:1:(sprintf('%#.3g', $2)) with labels left offset 1, 0 notitle\n",
          s);
    fprintf(plot->description, "Mean held-out error in mm:");
    for (int k = 0; k < n; k++)
        fprintf(plot->description, "%s %s %#.3g", k ? ";" : "", rungs[k].name, rungs[k].value * mm);
    fprintf(plot->description, ".");
    return true;
}

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
    double residual = 0, left = 0;
    snprintf(id, sizeof id, "joint-%d", index + 1);
    snprintf(title, sizeof title, "Error over the %s of %s", coordinate, e->name);
    mukca_plot_begin(plot, id, title, MUKCA_PLOT_HALF, 320);
    FILE *s = plot->script;
    fputs("$d << EOD\n", s);
    for (int k = 0; k < rows; k++) {
        const double error = r->joint_error[k * n + index] * mm;
        const double effect = r->joint_effect ? r->joint_effect[k * n + index] * mm : 0;
        fprintf(s, "%.3f %.5g %.5g\n", r->data.q[k * n + index] * unit, error, effect);
        residual += error * error / rows;
        left += (error - effect) * (error - effect) / rows;
    }
    fprintf(s,
            "EOD\nset xlabel '%s, %s'\nset ylabel 'error along its motion, mm' offset 1,0\nset "
            "xzeroaxis lc rgb 'black' lw 0.6\n"
            "plot $d using 1:2 with points lc rgb " PLOT_BEFORE
            " pt 6 ps 0.5 title 'after geometry'",
            coordinate, turns ? "deg" : "mm");
    if (r->joint_effect)
        fputs(", $d using 1:3 with points lc rgb " PLOT_AFTER
              " pt 7 ps 0.4 title 'explained by the causes'",
              s);
    fputc('\n', s);
    fprintf(plot->description,
            "The part of each sample's error along which %s moves the %s, over the "
            "joint's %s: %.3g mm rms after geometry",
            e->name, r->data.n_sockets > 0 ? "ball" : "target", coordinate, sqrt(residual));
    if (r->joint_effect)
        fprintf(plot->description, ", %.3g mm with the causes modelled", sqrt(left));
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
        const double error = mukca_norm3(r->residual + 3 * k) * mm;
        if (!isfinite(error)) continue;
        fprintf(s, data->socket[k] % 2 > 0 ? "%d NaN %.5g\n" : "%d %.5g NaN\n", k + 1, error);
        most = fmax(most, error);
    }
    fputs("EOD\n$f << EOD\n", s);
    for (int i = 0; i < r->diagnosed.diagnosis->n_faults; i++) {
        const int row = r->diagnosed.diagnosis->faults[i].data_row;
        fprintf(s, "%d %.5g\n", row + 1, mukca_norm3(r->residual + 3 * row) * mm);
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
            "%d samples after calibration; largest error %.3g mm; %d recording "
            "fault%s marked.",
            data->n_rows, most, r->diagnosed.diagnosis->n_faults,
            r->diagnosed.diagnosis->n_faults == 1 ? "" : "s");
    return true;
}
