/* The report's figures of the diagnosis: gap ladder, errors by joint and by row, offsets. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "report/parts.h"

static const double mm = 1e3;

/* ---- gap ladder ---- */

typedef struct {
    char name[200];
    double value, low, high; /* m; NaN where not known */
} rung;

static int add_rung(rung *rungs, int n, int room, const char *name, double value)
{
    if (n >= room || !isfinite(value)) return n;
    snprintf(rungs[n].name, sizeof rungs[n].name, "%s", name);
    rungs[n].value = rungs[n].low = rungs[n].high = value;
    return n + 1;
}

/* A rung of a contract's held_out object; its interval is one of the shrink in per cent. */
static int add_held_out(rung *rungs, int n, int room, const char *name, const json_t *held_out,
                        double usual)
{
    const json_t *ci = json_object_get(held_out, "ci95");
    const double before = report_real(held_out, "before_m");
    char text[200];
    snprintf(text, sizeof text, "%s", name);
    if (fabs(before - usual) > 0.01 * usual) /* sockets were left out, not placements */
        snprintf(text, sizeof text, "%.160s (from %.3g)", name, before * mm);
    const int m = add_rung(rungs, n, room, text, report_real(held_out, "after_m"));
    if (m > n && json_array_size(ci) == 2 && isfinite(before)) {
        rungs[n].low = before * (1 - json_number_value(json_array_get(ci, 1)) / 100);
        rungs[n].high = before * (1 - json_number_value(json_array_get(ci, 0)) / 100);
    }
    return m;
}

void report_draw_ladder(report_sheet *sheet, const mukca_report *r, int index)
{
    (void)index;
    enum { ROOM = 24 };
    rung rungs[ROOM] = {0};
    const json_t *gap = json_object_get(r->diagnosis, "gap"), *cause;
    const json_t *causes = json_object_get(r->diagnosis, "causes");
    const double floor = report_real(gap, "noise_floor_m");
    const double geometry = report_real(gap, "geometry_m");
    const double excused = report_real(gap, "faults_excused_m");
    int n = 0;
    size_t i;
    n = add_rung(rungs, n, ROOM, "nominal model", report_real(gap, "nominal_m"));
    n = add_rung(rungs, n, ROOM, "calibrated geometry", geometry);
    if (json_array_size(json_object_get(r->diagnosis, "data_faults")) > 0)
        n = add_rung(rungs, n, ROOM, "faulty rows excused", excused);
    json_array_foreach(causes, i, cause)
    {
        char name[160];
        report_name_cause(name, sizeof name, cause);
        snprintf(name + strlen(name), sizeof name - strlen(name), "%s",
                 json_array_size(causes) > 1 ? " alone" : "");
        n = add_held_out(rungs, n, ROOM - 1, name, json_object_get(cause, "held_out"), excused);
    }
    if (json_array_size(causes) > 1)
        n = add_held_out(rungs, n, ROOM, "all causes together", json_object_get(gap, "held_out"),
                         excused);
    /* A nominal model that is so far off that it would press the others together stands at the
     * edge. */
    size_t longest = 0;
    double most = floor > 0 ? floor : 0;
    for (int k = 0; k < n; k++) {
        longest = strlen(rungs[k].name) > longest ? strlen(rungs[k].name) : longest;
        if (k > 0) most = fmax(most, fmax(rungs[k].value, rungs[k].high));
    }
    const double edge = 1.25 * most * mm, nominal = rungs[0].value * mm;
    const bool beyond = nominal > edge;
    report_begin(sheet, "gap-ladder", "Held-out error, step by step", 720, 130 + 26 * n);
    FILE *s = sheet->script;
    fputs("$d << EOD\n", s);
    for (int k = beyond; k < n; k++)
        fprintf(s, "%d %.6g %.6g %.6g\n", n - k, rungs[k].value * mm, rungs[k].low * mm,
                rungs[k].high * mm);
    fputs("EOD\nset ytics (", s);
    for (int k = 0; k < n; k++) {
        fputs(k ? ", " : "", s);
        mukca_plot_quote(s, rungs[k].name);
        fprintf(s, " %d", n - k);
    }
    fprintf(
        s,
        ")\nset yrange [0.4:%g]\nset xrange [0:%g]\nset lmargin %d\nset rmargin 3\nset tmargin 2\n"
        "set xlabel 'mean error on placements left out of the fit, mm'\n",
        n + 0.6, edge, 2 + (int)(0.88 * (double)longest));
    if (beyond)
        fprintf(s,
                "set arrow from first %g, %d to first %g, %d linecolor rgb " PLOT_BEFORE
                " linewidth 2\nset label '%.3g ' at first %g, %d right\n",
                0.94 * edge, n, edge, n, nominal, 0.94 * edge, n);
    if (floor > 0)
        fprintf(s,
                "set arrow from first %g, graph 0 to first %g, graph 1 nohead linecolor 'black' "
                "dashtype 2\nset label 'noise floor' at first %g, graph 1 offset 0, 0.6 center\n",
                floor * mm, floor * mm, floor * mm);
    fputs("plot $d using 2:1 with points lc rgb " PLOT_AFTER
          " pt 7 notitle, "
          "$d using 2:1:3:4 with xerrorbars lc rgb " PLOT_AFTER
          " pt 7 ps 0 lw 1.5 notitle, "
          "$d using 2:1:(sprintf('%.3g', $2)) with labels left offset 0.8, 0.55 notitle\n",
          s);
    report_describe(sheet, "Mean held-out error in mm:");
    for (int k = 0; k < n; k++)
        report_describe(sheet, "%s %s %.3g", k ? ";" : "", rungs[k].name, rungs[k].value * mm);
    if (floor > 0) report_describe(sheet, "; noise floor %.3g", floor * mm);
    report_describe(sheet, ".");
}

/* ---- error against the angle of one joint ---- */

void report_draw_joint(report_sheet *sheet, const mukca_report *r, int index)
{
    const int n = r->chain->n_joints, rows = r->data->n_rows;
    const mukca_element *e = &r->chain->element[r->chain->joint_element[index]];
    const bool turns = e->type != MUKCA_PRISMATIC;
    const double unit = turns ? 180 / M_PI : mm;
    char id[64], title[160];
    double residual = 0, left = 0;
    snprintf(id, sizeof id, "joint-%d", index + 1);
    snprintf(title, sizeof title, "Error against the angle of %s", e->name);
    report_begin(sheet, id, title, 480, 320);
    FILE *s = sheet->script;
    fputs("$d << EOD\n", s);
    for (int k = 0; k < rows; k++) {
        const double error = r->joint_error[k * n + index] * mm;
        const double effect = r->joint_effect ? r->joint_effect[k * n + index] * mm : 0;
        fprintf(s, "%.3f %.5g %.5g\n", r->data->q[k * n + index] * unit, error, effect);
        residual += error * error;
        left += (error - effect) * (error - effect);
    }
    residual = sqrt(residual / rows);
    left = sqrt(left / rows);
    fprintf(s,
            "EOD\nset xlabel '%s'\nset ylabel 'error along its motion, mm' offset 1,0\nset "
            "xzeroaxis lc rgb 'black' lw "
            "0.6\nplot $d using 1:2 with points lc rgb " PLOT_BEFORE
            " pt 6 ps 0.5 title 'after geometry'",
            turns ? "angle, deg" : "position, mm");
    if (r->joint_effect)
        fputs(", $d using 1:3 with points lc rgb " PLOT_AFTER
              " pt 7 ps 0.4 title 'explained by the causes'",
              s);
    fputc('\n', s);
    report_describe(sheet,
                    "The part of each row's error along which the ball moves with %s, over the "
                    "joint's %s: %.3g mm rms after geometry",
                    e->name, turns ? "angle" : "position", residual);
    if (r->joint_effect) report_describe(sheet, ", %.3g mm once the causes are modelled", left);
    report_describe(sheet, ".");
}

/* ---- error of each row in recording order, faults marked ---- */

/* Index of the row with that number in a file of that placement and socket, -1 where none. */
static int find_row(const mukca_dataset *data, const json_t *fault)
{
    const char *place = report_text(fault, "placement"), *socket = report_text(fault, "socket");
    const int row = (int)json_integer_value(json_object_get(fault, "row"));
    for (int r = 0; r < data->n_rows; r++) {
        const int s = data->socket[r];
        if (s < 0 || (row > 0 && data->row[r] != row)) continue;
        if (*place && strcmp(data->placements[data->sockets[s].placement].name, place) != 0)
            continue;
        if (*socket && strcmp(data->sockets[s].label, socket) != 0) continue;
        return r;
    }
    return -1;
}

void report_draw_rows(report_sheet *sheet, const mukca_report *r, int index)
{
    (void)index;
    const mukca_dataset *data = r->data;
    double *errors = report_row_errors(r->calibrated, data), most = 0;
    const json_t *faults = json_object_get(r->diagnosis, "data_faults"), *fault;
    size_t i;
    report_begin(sheet, "rows", "Error of each row, in the order of recording", 960, 360);
    if (!errors) return;
    FILE *s = sheet->script;
    fputs("$d << EOD\n", s);
    for (int k = 0; k < data->n_rows; k++) {
        if (data->socket[k] < 0) continue;
        const bool odd = data->socket[k] % 2;
        fprintf(s, odd ? "%d NaN %.5g\n" : "%d %.5g NaN\n", k + 1, errors[k] * mm);
        most = fmax(most, errors[k] * mm);
    }
    fputs("EOD\n$f << EOD\n", s);
    json_array_foreach(faults, i, fault)
    {
        const int k = find_row(data, fault);
        if (k >= 0) fprintf(s, "%d %.5g\n", k + 1, errors[k] * mm);
    }
    fputs("EOD\n", s);
    int label = 1;
    for (int k = 0; k < data->n_rows; k++) {
        const int p = mukca_dataset_placement(data, k);
        if (p < 0 || (k > 0 && p == mukca_dataset_placement(data, k - 1))) continue;
        fprintf(
            s,
            "set arrow from first %g, graph 0 to first %g, graph 1 nohead lc rgb 'gray' lw 0.8\n"
            "set label %d ",
            k + 0.5, k + 0.5, label++);
        mukca_plot_quote(s, data->placements[p].name);
        fprintf(s, " at first %g, graph 0.99 left rotate by -90 offset 0.7, 0\n", k + 0.5);
    }
    fprintf(s,
            "set xrange [0:%d]\nset yrange [0:%g]\nset xlabel 'row'\n"
            "set ylabel 'distance from the socket''s mean, mm' offset 1,0\n"
            "plot $d using 1:2 with points lc rgb " PLOT_AFTER
            " pt 7 ps 0.5 title 'first socket', "
            "$d using 1:3 with points lc rgb " PLOT_THIRD " pt 9 ps 0.5 title 'other socket'%s\n",
            data->n_rows + 1, most > 0 ? 1.15 * most : 1,
            json_array_size(faults) > 0 ? ", $f using 1:2 with points lc rgb " PLOT_BEFORE
                                          " pt 2 ps 1.6 lw 2 title 'fault'"
                                        : "");
    report_describe(sheet,
                    "%d rows of %d placements after calibration; the largest error is %.3g mm; %d "
                    "faults of recording are marked.",
                    data->n_rows, data->n_placements, most, (int)json_array_size(faults));
    free(errors);
}

/* ---- offsets with their sigmas ---- */

void report_draw_offsets(report_sheet *sheet, const mukca_report *r, int index)
{
    const json_t *parameters = json_object_get(r->calibration, "parameters"), *p;
    const bool angles = index == 1;
    const char *last = "";
    size_t i;
    int n = 0, known = 0;
    char ticks[4096] = "";
    size_t used = 0;
    report_begin(
        sheet, angles ? "offsets-angles" : "offsets-lengths",
        angles ? "Offsets of angles (bars: two sigma)" : "Offsets of lengths (bars: two sigma)",
        640, 340);
    FILE *s = sheet->script;
    fputs("$d << EOD\n", s);
    json_array_foreach(parameters, i, p)
    {
        const char *unit = report_text(p, "unit"), *joint = report_text(p, "joint");
        const double sigma = report_real(p, "sigma");
        if (strcmp(unit, angles ? "rad" : "m") != 0) continue;
        n++;
        if (strcmp(joint, last) != 0) {
            last = joint;
            if (used + 2 * MUKCA_NAME_SIZE + 16 < sizeof ticks) {
                FILE *t = fmemopen(ticks + used, sizeof ticks - used, "w");
                if (t) {
                    if (used) fputs(", ", t);
                    mukca_plot_quote(t, joint);
                    fprintf(t, " %d", n);
                    fclose(t);
                    used = strlen(ticks);
                }
            }
        }
        if (isfinite(sigma)) {
            fprintf(s, "%d %.6g %.6g NaN\n", n, report_real(p, "offset") * mm, 2 * sigma * mm);
            known++;
        } else {
            fprintf(s, "%d NaN NaN %.6g\n", n, report_real(p, "offset") * mm);
        }
    }
    fprintf(s,
            "EOD\nset xtics (%s) rotate by -45\nset xrange [0:%d]\nset ylabel '%s'\n"
            "set xzeroaxis lc rgb 'black' lw 0.6\n"
            "plot $d using 1:2:3 with yerrorbars lc rgb " PLOT_AFTER
            " pt 7 ps 0.5 title 'identifiable'"
            ", $d using 1:4 with points lc rgb " PLOT_BEFORE
            " pt 6 ps 0.7 title 'not identifiable'\n",
            ticks, n + 1, angles ? "offset, mrad" : "offset, mm");
    report_describe(sheet,
                    "Offset of each %s parameter with two standard deviations, joint after joint; "
                    "%d of %d are identifiable. The table below holds the same numbers.",
                    angles ? "angle" : "length", known, n);
}
