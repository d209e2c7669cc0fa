/* The report's figures of the calibration, as gnuplot scripts: training, placements, centres,
 * matrix. */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "report/parts.h"

static const double mm = 1e3;

void report_begin(report_sheet *sheet, const char *id, const char *title, int width, int height)
{
    snprintf(sheet->id, sizeof sheet->id, "%s", id);
    snprintf(sheet->title, sizeof sheet->title, "%s", title);
    sheet->width = width;
    sheet->height = height;
    fputs(
        "set border 3 linewidth 0.8\n"
        "set tics nomirror out scale 0.6\n"
        "set grid linecolor 'gray' linewidth 0.4 dashtype 3\n"
        "set key above left horizontal Left reverse samplen 2\n",
        sheet->script);
}

void report_describe(report_sheet *sheet, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vfprintf(sheet->description, format, args);
    va_end(args);
}

double *report_row_errors(const double *positions, const mukca_dataset *data)
{
    double(*mean)[3] = calloc((size_t)data->n_sockets + 1, sizeof *mean);
    int *count = calloc((size_t)data->n_sockets + 1, sizeof *count);
    double *error = calloc((size_t)data->n_rows + 1, sizeof *error);
    if (mean && count && error) {
        for (int r = 0; r < data->n_rows; r++) {
            const int s = data->socket[r];
            if (s < 0) continue;
            count[s]++;
            for (int i = 0; i < 3; i++) mean[s][i] += positions[3 * r + i];
        }
        for (int r = 0; r < data->n_rows; r++) {
            const int s = data->socket[r];
            double sum = 0;
            for (int i = 0; s >= 0 && i < 3; i++) {
                const double d = positions[3 * r + i] - mean[s][i] / count[s];
                sum += d * d;
            }
            error[r] = sqrt(sum);
        }
    } else {
        free(error);
        error = NULL;
    }
    free(mean);
    free(count);
    return error;
}

/* ---- training curves ---- */

static int count_training(const mukca_report *r)
{
    return r->n_steps > 1;
}

/* A logarithmic axis has no zero: a hundredth of a micrometre stands in. */
static double shown(double metres)
{
    return fmax(metres, 1e-8) * mm;
}

static void draw_training(report_sheet *sheet, const mukca_report *r, int index)
{
    (void)index;
    report_begin(sheet, "training", "Consistency and distortion while the fit runs", 640, 400);
    FILE *s = sheet->script;
    const mukca_report_step *last = &r->steps[r->n_steps - 1];
    const bool test = isfinite(last->test_consistency);
    fputs("$d << EOD\n", s);
    for (int i = 0; i < r->n_steps; i++) {
        const mukca_report_step *p = &r->steps[i];
        fprintf(s, "%d %g %g", i, shown(p->train_consistency), shown(p->train_distortion));
        if (test) fprintf(s, " %g %g", shown(p->test_consistency), shown(p->test_distortion));
        fputc('\n', s);
    }
    fputs(
        "EOD\nset logscale y\nset format y '%g'\nset xlabel 'iteration'\nset ylabel 'mm'\n"
        "set xrange [0:*]\n",
        s);
    fprintf(s, "set xtics %d\n", 1 + r->n_steps / 9);
    if (r->repeatability > 0)
        fprintf(
            s,
            "set yrange [*<%g:*]\nset arrow from graph 0, first %g to graph 1, first %g nohead "
            "linecolor 'black' dashtype 2\nset label 'repeatability, %g mm' at graph 0.99, first "
            "%g right offset 0, 0.5\n",
            0.5 * r->repeatability * mm, r->repeatability * mm, r->repeatability * mm,
            r->repeatability * mm, r->repeatability * mm);
    fputs("plot $d using 1:2 with linespoints lc rgb " PLOT_AFTER
          " pt 7 ps 0.5 title 'consistency, train', "
          "$d using 1:3 with linespoints lc rgb " PLOT_BEFORE
          " pt 5 ps 0.5 title 'distortion, train'",
          s);
    if (test)
        fputs(", $d using 1:4 with linespoints lc rgb " PLOT_AFTER
              " dt 2 pt 6 ps 0.6 title 'consistency, held out', "
              "$d using 1:5 with linespoints lc rgb " PLOT_BEFORE
              " dt 2 pt 4 ps 0.6 title 'distortion, held out'",
              s);
    fputc('\n', s);
    report_describe(sheet,
                    "Over %d iterations the spread of the predictions within a socket falls from "
                    "%.3g to %.3g mm on the training rows, the error of the distance between "
                    "sockets from %.3g to %.3g mm.",
                    r->n_steps - 1, r->steps[0].train_consistency * mm,
                    last->train_consistency * mm, r->steps[0].train_distortion * mm,
                    last->train_distortion * mm);
    if (test)
        report_describe(sheet, " On held-out rows the spread ends at %.3g mm.",
                        last->test_consistency * mm);
}

/* ---- per placement: error and distance ---- */

static size_t placements(const mukca_report *r)
{
    return json_array_size(json_object_get(r->calibration, "train")) +
           json_array_size(json_object_get(r->calibration, "test"));
}

static const json_t *placement(const mukca_report *r, size_t i, bool *test)
{
    const json_t *train = json_object_get(r->calibration, "train");
    const size_t n = json_array_size(train);
    *test = i >= n;
    return i < n ? json_array_get(train, i)
                 : json_array_get(json_object_get(r->calibration, "test"), i - n);
}

static int count_placements(const mukca_report *r)
{
    return placements(r) > 0 ? 2 : 0;
}

static void draw_placements(report_sheet *sheet, const mukca_report *r, int index)
{
    static const struct {
        const char *id, *title, *before, *after, *label;
    } kinds[2] = {{"error-by-placement", "Mean absolute error of each placement", "mae_nominal_m",
                   "mae_m", "mean error of a row, mm"},
                  {"distance-error", "Error of the distance between the sockets",
                   "distance_error_nominal_m", "distance_error_m", "error of the distance, mm"}};
    const int n = (int)placements(r);
    report_begin(sheet, kinds[index].id, kinds[index].title, 480, 120 + 24 * n);
    FILE *s = sheet->script;
    double before = 0, after = 0;
    fputs("$d << EOD\n", s);
    for (int i = 0; i < n; i++) {
        bool test;
        const json_t *p = placement(r, (size_t)i, &test);
        const double b = report_real(p, kinds[index].before),
                     a = report_real(p, kinds[index].after);
        fprintf(s, "%d %.6g %.6g\n", n - i, shown(b), shown(a));
        before += b / n;
        after += a / n;
    }
    fputs("EOD\nset ytics (", s);
    for (int i = 0; i < n; i++) {
        bool test;
        char name[MUKCA_NAME_SIZE + 16];
        snprintf(name, sizeof name, "%s", report_text(placement(r, (size_t)i, &test), "placement"));
        if (test) strcat(name, " (held out)");
        fputs(i ? ", " : "", s);
        mukca_plot_quote(s, name);
        fprintf(s, " %d", n - i);
    }
    fprintf(s,
            ")\nset yrange [0.4:%g]\nset logscale x\nset format x '%%g'\nset xlabel '%s'\n"
            "plot $d using 2:1:($3-$2):(0) with vectors nohead lc rgb 'gray' notitle, "
            "$d using 2:1 with points lc rgb " PLOT_BEFORE
            " pt 6 lw 2 title 'nominal', "
            "$d using 3:1 with points lc rgb " PLOT_AFTER " pt 7 title 'calibrated'\n",
            n + 0.6, kinds[index].label);
    report_describe(sheet, "On the average of %d placements: %.3g mm nominal, %.3g mm calibrated.",
                    n, before * mm, after * mm);
}

/* ---- predicted ball centres, three projections of one placement ---- */

static int count_centres(const mukca_report *r)
{
    return r->data->n_sockets > 0 ? r->data->n_placements : 0;
}

static void put_centres(FILE *s, const char *block, const double *positions, const double *origin,
                        const mukca_dataset *data, int place)
{
    for (int k = 0, shape = 0; k < data->n_sockets; k++) {
        if (data->sockets[k].placement != place) continue;
        fprintf(s, "$%s%d << EOD\n", block, shape++);
        for (int r = 0; r < data->n_rows; r++)
            if (data->socket[r] == k)
                fprintf(s, "%.4f %.4f %.4f\n", (positions[3 * r] - origin[0]) * mm,
                        (positions[3 * r + 1] - origin[1]) * mm,
                        (positions[3 * r + 2] - origin[2]) * mm);
        fputs("EOD\n", s);
    }
}

static void draw_centres(report_sheet *sheet, const mukca_report *r, int index)
{
    static const char axes[3][3] = {"xy", "xz", "yz"};
    static const int open_point[4] = {6, 8, 4, 12}, full_point[4] = {7, 9, 5, 13};
    const mukca_dataset *data = r->data;
    char id[64], title[160];
    double origin[3] = {0};
    double reach = 0;
    int rows = 0, sockets = 0;
    snprintf(id, sizeof id, "centres-%d", index + 1);
    snprintf(title, sizeof title, "Predicted ball centres, %s%s", data->placements[index].name,
             r->held_out[index] ? " (held out)" : "");
    report_begin(sheet, id, title, 960, 370);
    for (int k = 0; k < data->n_rows; k++) {
        if (data->socket[k] < 0 || data->sockets[data->socket[k]].placement != index) continue;
        for (int i = 0; i < 3; i++) origin[i] += r->calibrated[3 * k + i];
        rows++;
    }
    for (int i = 0; i < 3 && rows > 0; i++) origin[i] /= rows;
    for (int k = 0; k < data->n_sockets; k++) sockets += data->sockets[k].placement == index;
    for (int k = 0; k < data->n_rows; k++) {
        if (data->socket[k] < 0 || data->sockets[data->socket[k]].placement != index) continue;
        for (int i = 0; i < 3; i++) {
            reach = fmax(reach, fabs(r->calibrated[3 * k + i] - origin[i]) * mm);
            reach = fmax(reach, fabs(r->nominal[3 * k + i] - origin[i]) * mm);
        }
    }
    FILE *s = sheet->script;
    put_centres(s, "b", r->nominal, origin, data, index);
    put_centres(s, "a", r->calibrated, origin, data, index);
    fputs("set multiplot layout 1,3 margins 0.07,0.985,0.17,0.9 spacing 0.075\n", s);
    fprintf(s,
            "set size ratio -1\nset xrange [%g:%g]\nset yrange [%g:%g]\nset key at graph 0, 1.1\n",
            -1.05 * reach, 1.05 * reach, -1.05 * reach, 1.05 * reach);
    for (int panel = 0; panel < 3; panel++) {
        const int u = axes[panel][0] - 'x' + 1, v = axes[panel][1] - 'x' + 1;
        fprintf(s, "set xlabel '%c, mm'\nset ylabel '%c, mm' offset 1,0\nplot ", axes[panel][0],
                axes[panel][1]);
        for (int k = 0; k < sockets; k++)
            fprintf(s, "$b%d using %d:%d with points lc rgb " PLOT_BEFORE " pt %d ps 0.7 %s, ", k,
                    u, v, open_point[k % 4], panel == 0 && k == 0 ? "title 'nominal'" : "notitle");
        for (int k = 0; k < sockets; k++)
            fprintf(s, "$a%d using %d:%d with points lc rgb " PLOT_AFTER " pt %d ps 0.6 %s%s", k, u,
                    v, full_point[k % 4], panel == 1 && k == 0 ? "title 'calibrated'" : "notitle",
                    k + 1 < sockets ? ", " : "\n");
    }
    fputs("unset multiplot\n", s);
    report_describe(sheet,
                    "Where the model puts the ball in each of %d rows of %d sockets, in the base "
                    "frame about the placement's middle, seen along z, y and x, at true scale: "
                    "scattered with the nominal model, gathered to one point per socket after "
                    "calibration.",
                    rows, sockets);
}

/* ---- trained here, tested there ---- */

static int count_bars(const mukca_report *r)
{
    return r->n_bars > 0;
}

static void draw_bars(report_sheet *sheet, const mukca_report *r, int index)
{
    (void)index;
    report_begin(sheet, "generalisation", "Error on placements that were not trained on", 640,
                 100 + 20 * r->n_bars);
    FILE *s = sheet->script;
    const mukca_report_bar *best = r->bars;
    fputs("$d << EOD\n", s);
    for (int i = 0; i < r->n_bars; i++) {
        const mukca_report_bar *b = &r->bars[i];
        fprintf(s, "%d %.5g %.5g %.5g\n", r->n_bars - i, b->mean * mm, b->low * mm, b->high * mm);
        if (b->mean < best->mean) best = b;
    }
    fputs("EOD\nset ytics (", s);
    for (int i = 0; i < r->n_bars; i++) {
        fputs(i ? ", " : "", s);
        mukca_plot_quote(s, r->bars[i].trained);
        fprintf(s, " %d", r->n_bars - i);
    }
    fprintf(
        s,
        ")\nset yrange [0.4:%g]\nset xrange [0:*]\nset xlabel 'mean error on the others, mm "
        "(bar: mean, line: best to worst)'\nset style fill solid 0.45 border\n"
        "set boxwidth 0.6\nplot $d using ($2/2):1:($2/2):(0.3) with boxxyerror lc rgb " PLOT_AFTER
        " notitle, $d using 2:1:3:4 with xerrorbars lc rgb 'black' pt 0 notitle\n",
        r->n_bars + 0.6);
    report_describe(sheet,
                    "One bar for each set of training placements; the least mean error, %.3g mm, "
                    "is that of training on %s.",
                    best->mean * mm, best->trained);
}

/* ---- the table of all figures ---- */

static int count_ladder(const mukca_report *r)
{
    return isfinite(report_real(json_object_get(r->diagnosis, "gap"), "geometry_m"));
}

static int count_joints(const mukca_report *r)
{
    return r->joint_error ? r->chain->n_joints : 0;
}

static int count_rows(const mukca_report *r)
{
    return r->data->n_sockets > 0;
}

static int count_offsets(const mukca_report *r)
{
    return json_array_size(json_object_get(r->calibration, "parameters")) > 0 ? 2 : 0;
}

const report_figure report_figures[] = {
    {REPORT_GAP, count_ladder, report_draw_ladder},
    {REPORT_TRAINING, count_training, draw_training},
    {REPORT_PLACEMENTS, count_placements, draw_placements},
    {REPORT_CENTRES, count_centres, draw_centres},
    {REPORT_MATRIX, count_bars, draw_bars},
    {REPORT_JOINTS, count_joints, report_draw_joint},
    {REPORT_ROWS, count_rows, report_draw_rows},
    {REPORT_OFFSETS, count_offsets, report_draw_offsets},
};
const int report_n_figures = (int)(sizeof report_figures / sizeof *report_figures);

void report_sheet_free(report_sheet *sheet)
{
    free(sheet->text);
    free(sheet->words);
    sheet->text = sheet->words = NULL;
}

mukca_status report_draw(mukca_figure *figure, report_sheet *sheet, const report_figure *kind,
                         int index, const mukca_report *report, mukca_error *error)
{
    memset(sheet, 0, sizeof *sheet);
    sheet->script = open_memstream(&sheet->text, &sheet->sizes[0]);
    sheet->description = open_memstream(&sheet->words, &sheet->sizes[1]);
    bool failed = !sheet->script || !sheet->description;
    if (!failed) kind->draw(sheet, report, index);
    if (sheet->script) failed |= fclose(sheet->script) != 0;
    if (sheet->description) failed |= fclose(sheet->description) != 0;
    if (failed) {
        report_sheet_free(sheet);
        return mukca_fail(error, MUKCA_MEMORY, "out of memory while drawing the report");
    }
    *figure = (mukca_figure){sheet->id, sheet->title, sheet->words, sheet->width, sheet->height};
    return MUKCA_OK;
}
