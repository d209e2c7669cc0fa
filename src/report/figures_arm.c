/* Axonometric figure: the arm, the placements and the residual vectors. */
#include <math.h>
#include <stdlib.h>

#include "math/stats.h"
#include "report/parts.h"

enum {
    MOST_VECTORS = 600, /* a long recording is thinned to every n-th sample */
    MOST_ARMS = 9       /* postures; the first is drawn in full, the others faint */
};
/* The camera is 25 degrees above the horizon, at an azimuth of 60 degrees from the mean of the
 * samples: both depth and height are visible. */
static const double elevation = 25 * M_PI / 180, aside = 60 * M_PI / 180;
/* Length of the drawn vectors: their 90 % quantile as a fraction of the picture. */
static const double vector_share = 0.1;
static const double axis_length = 0.15; /* m */

/* Orthographic projection, and the bounding rectangle of the points projected so far, m. */
typedef struct {
    FILE *script;
    double right[3], up[3];
    double low[2], high[2];
} view;

/* A view with the mean of the samples to the right of the base. */
static view aim(FILE *script, const mukca_report *r)
{
    double x = 0, y = 0;
    for (int i = 0; i < r->data.n_rows; i++)
        x += r->calibrated[3 * i], y += r->calibrated[3 * i + 1];
    const double azimuth = atan2(y, x) - aside;
    return (view){
        .script = script,
        .right = {-sin(azimuth), cos(azimuth), 0},
        .up = {-sin(elevation) * cos(azimuth), -sin(elevation) * sin(azimuth), cos(elevation)},
        .low = {HUGE_VAL, HUGE_VAL},
        .high = {-HUGE_VAL, -HUGE_VAL}};
}

static void project(double uv[2], const view *v, const double p[3])
{
    uv[0] = uv[1] = 0;
    for (int k = 0; k < 3; k++) uv[0] += v->right[k] * p[k], uv[1] += v->up[k] * p[k];
}

/* Write a projected point and extend the rectangle to it. */
static void put_point(view *v, const double p[3])
{
    double uv[2];
    project(uv, v, p);
    for (int k = 0; k < 2; k++) {
        v->low[k] = fmin(v->low[k], uv[k]);
        v->high[k] = fmax(v->high[k], uv[k]);
    }
    fprintf(v->script, "%.5f %.5f\n", uv[0], uv[1]);
}

static bool of_placement(const mukca_dataset *data, int sample, int placement)
{
    return placement < 0 || mukca_dataset_placement(data, sample) == placement;
}

/* The middle sample, in recording order, of a placement (-1: of all); -1: there is none. */
static int middle_sample(const mukca_dataset *data, int placement)
{
    int count = 0;
    for (int i = 0; i < data->n_rows; i++) count += of_placement(data, i, placement);
    int before = count / 2;
    for (int i = 0; i < data->n_rows; i++)
        if (of_placement(data, i, placement) && before-- == 0) return i;
    return -1;
}

/* Print links and joints of one posture as block $arm<index>. */
static void put_arm(view *v, const mukca_report *r, int index, int sample)
{
    mukca_geometry geometry;
    mukca_frame before[MUKCA_MAX_ELEMENTS], tip;
    const mukca_chain *chain = r->fitted;
    const double origin[3] = {0};
    mukca_geometry_set(&geometry, chain, r->offsets->theta);
    mukca_fk_frames(before, &tip, &geometry, r->data.q + sample * r->data.n_joints, NULL);
    fprintf(v->script, "$arm%d << EOD\n", index);
    /* the chain of a pose log starts at the tracker; its first frame is the arm's base */
    if (chain->n_elements == r->chain->n_elements) put_point(v, origin);
    for (int k = 0; k < chain->n_elements; k++) put_point(v, before[k].p);
    put_point(v, tip.p);
    fputs("EOD\n", v->script);
}

/* Print each placement with its name, a plumb line to the base plane and a posture of the arm; for
 * a pose log one posture.  Returns the number of postures. */
static int put_placements(mukca_plot *plot, view *v, const mukca_report *r)
{
    const int placements = r->data.n_placements;
    int arms = 0;
    for (int p = placements > 0 ? 0 : -1; p < placements; p++) {
        const int sample = middle_sample(&r->data, p);
        if (sample < 0) continue;
        if (arms < MOST_ARMS) put_arm(v, r, arms++, sample);
        if (p < 0) continue;
        const double *tip = r->calibrated + 3 * sample, foot[3] = {tip[0], tip[1], 0};
        double from[2], to[2];
        project(from, v, tip);
        project(to, v, foot);
        fprintf(v->script, "set arrow from %.5f, %.5f to %.5f, %.5f nohead back dt 3 lw 0.8\n",
                from[0], from[1], to[0], to[1]);
        mukca_plot_label(plot, r->data.placements[p].name,
                         "at %.5f, %.5f left offset 2.5, -1 front", from[0], from[1]);
    }
    return arms;
}

/* Print a grid of the base plane below the base and all samples; returns its spacing, m. */
static double put_ground(view *v, const mukca_report *r)
{
    double low[2] = {-axis_length, -axis_length}, high[2] = {axis_length, axis_length};
    for (int i = 0; i < r->data.n_rows; i++)
        for (int k = 0; k < 2; k++) {
            low[k] = fmin(low[k], r->calibrated[3 * i + k]);
            high[k] = fmax(high[k], r->calibrated[3 * i + k]);
        }
    const double step = fmax(high[0] - low[0], high[1] - low[1]) > 1.5 ? 0.5 : 0.2;
    for (int k = 0; k < 2; k++) {
        low[k] = step * floor(low[k] / step);
        high[k] = step * ceil(high[k] / step);
    }
    fputs("$ground << EOD\n", v->script);
    for (int k = 0; k < 2; k++) {
        const long last = lround((high[k] - low[k]) / step);
        double at = low[k];
        for (long line = 0; line <= last; line++, at += step) {
            double p[3] = {at, at, 0};
            for (int end = 0; end < 2; end++) {
                p[1 - k] = end ? high[1 - k] : low[1 - k];
                put_point(v, p);
            }
            fputs("\n", v->script);
        }
    }
    fputs("EOD\n", v->script);
    return step;
}

static void put_axes(const view *v)
{
    for (int k = 0; k < 3; k++) {
        double tip[3] = {0}, uv[2];
        tip[k] = axis_length;
        project(uv, v, tip);
        fprintf(v->script,
                "set arrow from 0, 0 to %.5f, %.5f filled size screen 0.015, 20 lc rgb " PLOT_THIRD
                " lw 1.5 front\nset label '%c' at %.5f, %.5f center offset %d, 0 tc rgb " PLOT_THIRD
                " front\n",
                uv[0], uv[1], "xyz"[k], 1.25 * uv[0], 1.25 * uv[1], k == 2 ? -1 : 0);
    }
}

/* The largest of 1, 2, 5, 10, 20, ... not above x. */
static double round_down(double x)
{
    const double power = pow(10, floor(log10(x)));
    return x >= 5 * power ? 5 * power : x >= 2 * power ? 2 * power : power;
}

/* 90 % quantile of the residuals' lengths, m; 0: no residuals. */
static double large_residual(const mukca_report *r)
{
    double *length = calloc((size_t)r->data.n_rows + 1, sizeof *length), result = 0;
    int n = 0;
    for (int i = 0; length && i < r->data.n_rows; i++) {
        length[n] = mukca_norm3(r->residual + 3 * i);
        n += isfinite(length[n]);
    }
    if (n > 0) result = mukca_stats_quantile(length, n, 0.9);
    free(length);
    return result;
}

/* Print the magnified residuals, starting at the true positions, as block $<name>; returns their
 * number. */
static int put_residuals(view *v, const mukca_report *r, const char *name, const double *residual,
                         double scale)
{
    const int every = 1 + (r->data.n_rows - 1) / MOST_VECTORS;
    int n = 0;
    fprintf(v->script, "$%s << EOD\n", name);
    for (int i = 0; i < r->data.n_rows; i += every) {
        double from[3], to[3];
        for (int k = 0; k < 3; k++) {
            from[k] = r->calibrated[3 * i + k] - r->residual[3 * i + k];
            to[k] = from[k] + scale * residual[3 * i + k];
        }
        if (!isfinite(to[0] + to[1] + to[2])) continue;
        put_point(v, from);
        put_point(v, to);
        fputs("\n", v->script);
        n++;
    }
    fputs("EOD\n", v->script);
    return n;
}

bool mukca_report_arm(mukca_plot *plot, const mukca_report *r, int index)
{
    FILE *s = plot->script;
    const double large = large_residual(r);
    if (index > 0 || !(large > 0)) return false;
    mukca_plot_begin(
        plot, "arm",
        r->data.n_sockets > 0 ? "Arm, placements and residual vectors" : "Arm and residual vectors",
        MUKCA_PLOT_HALF, 0);
    view v = aim(s, r);
    const double step = put_ground(&v, r);
    const int arms = put_placements(plot, &v, r);
    put_axes(&v);
    const double size = fmax(v.high[0] - v.low[0], v.high[1] - v.low[1]);
    const double scale = round_down(vector_share * size / large), bar = round_down(large);
    const int vectors = put_residuals(&v, r, "geometry", r->residual, scale);
    if (r->explained) put_residuals(&v, r, "causes", r->explained, scale);
    const double margin = 0.04 * size, width = v.high[0] - v.low[0] + 3 * margin;
    const double height = v.high[1] - v.low[1] + 4 * margin;
    plot->height = 40 + (int)fmin(MUKCA_PLOT_HALF * height / width, 600);
    const double left = v.low[0], bottom = v.low[1] - 2 * margin;
    fprintf(s,
            "unset border\nunset tics\nunset grid\nset size ratio -1\nset margins 0, 0, 0, 2\n"
            "set xrange [%g:%g]\nset yrange [%g:%g]\n"
            "set arrow from %g, %g to %g, %g heads size screen 0.008, 90 lw 1.5\n"
            "set label '%g mm of residual' at %g, %g left offset 1, 0\n",
            v.low[0] - margin, v.high[0] + 2 * margin, bottom - margin, v.high[1] + margin, left,
            bottom, left + scale * bar, bottom, bar * MUKCA_REPORT_MM, left + scale * bar, bottom);
    fputs("plot $ground with lines lc rgb 'gray' lw 0.5 notitle, ", s);
    for (int k = arms - 1; k >= 0; k--)
        fprintf(s, "$arm%d with linespoints pt 7 lc rgb %s notitle, ", k,
                k ? "'gray' lw 1.2 ps 0.4" : "'black' lw 3 ps 0.8");
    fputs("$geometry with lines lc rgb " PLOT_BEFORE " lw 0.8 title 'after geometry', ", s);
    if (r->explained)
        fputs("$causes with lines lc rgb " PLOT_AFTER " lw 0.8 title 'with the causes', ", s);
    /* the first point of each vector is the socket */
    fprintf(s, "$geometry every ::0::0 with points lc rgb 'black' pt 7 ps %g notitle\n",
            r->data.n_sockets > 0 ? 0.5 : 0.1);
    fprintf(
        plot->description,
        "Axonometric view in the base frame, grid of %g m. Lines from each %s are the residuals of "
        "%d samples, enlarged %.0f times%s.",
        step, r->data.n_sockets > 0 ? "socket" : "measured position", vectors, scale,
        arms > 1 ? "; the arm is shown in one posture for each placement" : "");
    return true;
}
