/* Figures of the calibration: errors by placement. */
#include <math.h>

#include "report/parts.h"

static const double mm = MUKCA_REPORT_MM;

/* A logarithmic axis has no zero: a hundredth of a micrometre replaces it. */
static double positive(double metres)
{
    return fmax(metres, 1e-8) * mm;
}

bool mukca_report_placements(mukca_plot *plot, const void *content, int index)
{
    const mukca_report *r = content;
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
