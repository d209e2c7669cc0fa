/* Figures of the calibration: errors by placement, convergence, generalisation, offsets. */
#include <math.h>

#include "report/parts.h"

static const double mm = MUKCA_REPORT_MM;

/* A logarithmic axis has no zero: a hundredth of a micrometre replaces it. */
static double positive(double metres)
{
    return fmax(metres, 1e-8) * mm;
}

/* ---- errors by placement ---- */

bool mukca_report_placements(mukca_plot *plot, const mukca_report *r, int index)
{
    static const struct {
        const char *id, *title, *label;
    } kinds[3] = {
        {"error-by-placement", "Consistency error by placement", "mean consistency error, mm"},
        {"distance-error", "Distortion by placement", "distortion, mm"},
        {"position-error", "Position error", "mean distance from the measured position, mm"}};
    const int kind = r->data.n_sockets > 0 ? index : 2;
    const int n = r->n_scores;
    double before = 0, after = 0;
    int shown = 0;
    FILE *s = plot->script;
    fputs("$d << EOD\n", s);
    for (int i = 0; i < n && index < 2; i++) {
        const mukca_score *a = &r->scores[i].nominal, *b = &r->scores[i].calibrated;
        const double nominal = index == 0 ? a->mae : a->distance_error;
        const double calibrated = index == 0 ? b->mae : b->distance_error;
        if (!isfinite(nominal) || !isfinite(calibrated)) continue;
        fprintf(s, "%d %.6g %.6g\n", n - i, positive(nominal), positive(calibrated));
        before += nominal, after += calibrated, shown++;
    }
    fputs("EOD\n", s);
    if (shown == 0) return false;
    mukca_plot_begin(plot, kinds[kind].id, kinds[kind].title, MUKCA_PLOT_HALF, 120 + 24 * n);
    fputs("set ytics (", s);
    for (int i = 0; i < n; i++) {
        char name[MUKCA_NAME_SIZE + 16];
        snprintf(name, sizeof name, "%s%s", r->scores[i].placement,
                 r->scores[i].test ? " (test)" : "");
        fputs(i ? ", " : "", s);
        mukca_plot_tic(s, name);
        fprintf(s, " %d", n - i);
    }
    fprintf(s,
            ")\nset yrange [0.4:%g]\nset logscale x\nset format x '%%g'\nset xlabel '%s'\n"
            "plot $d using 2:1:($3-$2):(0) with vectors nohead lc rgb 'gray' notitle, "
            "$d using 2:1 with points lc rgb " PLOT_BEFORE
            " pt 6 lw 2 title 'nominal', "
            "$d using 3:1 with points lc rgb " PLOT_AFTER " pt 7 title 'calibrated'\n",
            n + 0.6, kinds[kind].label);
    fprintf(plot->description, "Mean of the %d line%s: %#.3g mm nominal, %#.3g mm calibrated.",
            shown, shown == 1 ? "" : "s", before / shown * mm, after / shown * mm);
    return true;
}

/* ---- convergence ---- */

bool mukca_report_convergence(mukca_plot *plot, const mukca_report *r, int index)
{
    if (index > 0 || r->n_steps < 2) return false;
    mukca_plot_begin(plot, "training", "Consistency error and distortion during the fit",
                     MUKCA_PLOT_HALF, 360);
    FILE *s = plot->script;
    static const struct {
        const char *title, *style;
    } curves[4] = {{"consistency, train", PLOT_AFTER " pt 7"},
                   {"distortion, train", PLOT_BEFORE " pt 5"},
                   {"consistency, test", PLOT_AFTER " dt 2 pt 6"},
                   {"distortion, test", PLOT_BEFORE " dt 2 pt 4"}};
    const double *first = r->steps[0].error, *last = r->steps[r->n_steps - 1].error;
    fputs("$d << EOD\n", s);
    for (int i = 0; i < r->n_steps; i++) {
        fprintf(s, "%d", i);
        for (int k = 0; k < 4; k++) fprintf(s, " %g", positive(r->steps[i].error[k]));
        fputc('\n', s);
    }
    fprintf(s,
            "EOD\nset logscale y\nset format y '%%g'\nset xlabel 'iteration'\nset ylabel 'mm'\n"
            "set xrange [0:*]\nset xtics %d\nset key maxcols 2\n",
            1 + r->n_steps / 9);
    if (r->repeatability > 0)
        fprintf(s,
                "rep = %g\nset yrange [*<0.5*rep:*]\n"
                "set arrow from graph 0, first rep to graph 1, first rep nohead linecolor 'black' "
                "dashtype 2\nset label sprintf('repeatability, %%g mm', rep) at graph 0.99, first "
                "rep right offset 0, 0.5\n",
                r->repeatability * mm);
    fprintf(plot->description, "Over %d iterations", r->n_steps - 1);
    for (int k = 0, shown = 0; k < 4; k++) {
        if (!isfinite(last[k])) continue;
        fprintf(s, "%s $d using 1:%d with linespoints lc rgb %s ps 0.6 title '%s'",
                shown ? "," : "plot", k + 2, curves[k].style, curves[k].title);
        fprintf(plot->description, "%s %s goes from %.3g to %.3g mm", shown ? ";" : "",
                curves[k].title, first[k] * mm, last[k] * mm);
        shown++;
    }
    fputc('\n', s);
    fprintf(plot->description, ".");
    return true;
}

/* ---- generalisation ---- */

bool mukca_report_generalisation(mukca_plot *plot, const mukca_report *r, int index)
{
    if (index > 0 || r->n_bars == 0) return false;
    mukca_plot_begin(plot, "generalisation", "Error on placements not used for training",
                     MUKCA_PLOT_HALF, 100 + 32 * r->n_bars);
    FILE *s = plot->script;
    const mukca_report_bar *best = r->bars;
    fputs("unset ytics\n$d << EOD\n", s);
    for (int i = 0; i < r->n_bars; i++) {
        const mukca_report_bar *b = &r->bars[i];
        fprintf(s, "%d %.5g %.5g %.5g\n", r->n_bars - i, b->mean * mm, b->low * mm, b->high * mm);
        if (b->mean < best->mean) best = b;
    }
    fputs("EOD\n", s);
    for (int i = 0; i < r->n_bars; i++)
        mukca_plot_label(plot, r->bars[i].trained, MUKCA_PLOT_ABOVE, r->n_bars - i);
    fprintf(s,
            "set yrange [0.6:%g]\nset xrange [0:*]\nset xlabel 'mean error on the other "
            "placements, mm (line: best to worst)'\nset style fill solid 0.45 border\n"
            "plot $d using ($2/2):1:($2/2):(0.15) with boxxyerror lc rgb " PLOT_AFTER
            " notitle, $d using 2:1:3:4 with xerrorbars lc rgb 'black' pt 0 notitle\n",
            r->n_bars + 0.8);
    fprintf(plot->description,
            "One bar for each set of training placements. Smallest mean error: %.3g "
            "mm, trained on %s.",
            best->mean * mm, best->trained);
    return true;
}

/* ---- offsets and their standard errors ---- */

bool mukca_report_offsets(mukca_plot *plot, const mukca_report *r, int index)
{
    const bool angles = index == 1;
    bool any = false;
    const mukca_offsets *table = r->offsets;
    double nominal[MUKCA_MAX_THETA];
    int n = 0, known = 0, first[MUKCA_MAX_ELEMENTS] = {0}; /* tic of its first offset, 0: none */
    mukca_chain_theta(nominal, r->fitted);
    if (index > 1) return false;
    mukca_plot_begin(
        plot, angles ? "offsets-angles" : "offsets-lengths",
        angles ? "Offsets of angles (bars: 2 sigma)" : "Offsets of lengths (bars: 2 sigma)",
        MUKCA_PLOT_HALF, 320);
    FILE *s = plot->script;
    fputs("set xtics () rotate by -45\n$d << EOD\n", s);
    for (int i = 0; i < MUKCA_PARAMETERS * r->fitted->n_elements; i++) {
        const double offset = (table->theta[i] - nominal[i]) * mm;
        any |= table->listed[i];
        if (!table->listed[i] || i % MUKCA_PARAMETERS / 3 != angles) continue;
        if (first[i / MUKCA_PARAMETERS] == 0) first[i / MUKCA_PARAMETERS] = n + 1;
        n++;
        if (table->identifiable[i] && isfinite(table->sigma[i])) {
            fprintf(s, "%d %.6g %.6g NaN\n", n, offset, 2 * table->sigma[i] * mm);
            known++;
        } else {
            fprintf(s, "%d NaN NaN %.6g\n", n, offset);
        }
    }
    fputs("EOD\n", s);
    if (!any) return false;
    for (int k = 0; k < r->fitted->n_elements; k++) {
        if (first[k] == 0) continue;
        fputs("set xtics add (", s);
        mukca_plot_tic(s, r->fitted->element[k].name);
        fprintf(s, " %d)\n", first[k]);
    }
    fprintf(s,
            "set xrange [0:%d]\nset ylabel '%s'\nset xzeroaxis lc rgb 'black' lw 0.6\n"
            "plot $d using 1:2:3 with yerrorbars lc rgb " PLOT_AFTER
            " pt 7 ps 0.5 title 'identifiable'"
            ", $d using 1:4 with points lc rgb " PLOT_BEFORE
            " pt 6 ps 0.7 title 'not identifiable'\n",
            n + 1, angles ? "offset, mrad" : "offset, mm");
    fprintf(plot->description,
            "Offset of each %s parameter with two standard deviations, joint by joint; "
            "%d of %d are identifiable. The table lists the same numbers.",
            angles ? "angle" : "length", known, n);
    return true;
}
