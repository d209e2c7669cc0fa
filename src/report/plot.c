/* Figures of a page: axes, key and points as SVG; their colours are in the page's style sheet. */
#include "report/page.h"

#include <math.h>
#include <string.h>

/* WIDTH, px: two figures per row, legible on a phone.  Margins, and a letter of the key, px. */
enum { WIDTH = 480, HEIGHT = 320, LEFT = 58, RIGHT = 16, TOP = 30, BOTTOM = 46, LETTER = 7 };

static const char *const series_class[MUKCA_PLOT_SERIES] = {"after", "before", "measured"};

/* 1, 2 or 5 times a power of ten, at most x. */
static double round_down(double x)
{
    const double power = pow(10, floor(log10(x)));
    return power * (x >= 5 * power ? 5 : x >= 2 * power ? 2 : 1);
}

/* An axis: its range in the unit of the points, and in px. */
typedef struct {
    bool vertical;
    double low, high, from, to;
} axis;

static double place(const axis *a, double value)
{
    return a->from + (value - a->low) / (a->high - a->low) * (a->to - a->from);
}

/* The range of all points, with a margin. */
static axis find_axis(const mukca_plot *p, int dimension)
{
    axis a = {.vertical = dimension == 1, .low = HUGE_VAL, .high = -HUGE_VAL};
    for (const mukca_plot_point *q = p->points; q < p->points + p->n_points; q++) {
        a.low = fmin(a.low, q->at[dimension]);
        a.high = fmax(a.high, q->at[dimension]);
    }
    if (!(a.low < a.high)) a.low -= 0.5, a.high += 0.5;
    const double margin = 0.04 * (a.high - a.low);
    a.low -= margin;
    a.high += margin;
    a.from = a.vertical ? HEIGHT - BOTTOM : LEFT;
    a.to = a.vertical ? TOP : WIDTH - RIGHT;
    return a;
}

/* A line across the plot, at a place on axis a, from one end of the other axis to its other end. */
static void put_line(FILE *out, const char *style, const axis *a, double at, const axis *other)
{
    fprintf(out,
            a->vertical ? "<path class=\"%s\" d=\"M%.1f %.1fH%.1f\"/>\n"
                        : "<path class=\"%s\" d=\"M%.1f %.1fV%.1f\"/>\n",
            style, a->vertical ? other->from : at, a->vertical ? at : other->from, other->to);
}

/* Numbers and grid of an axis. */
static void put_numbers(FILE *out, const axis *a, const axis *other)
{
    const double step = round_down((a->high - a->low) / 4);
    for (double k = ceil(a->low / step); k * step <= a->high; k++) {
        const double at = place(a, k * step);
        put_line(out, "grid", a, at, other);
        fprintf(out, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">%g</text>\n",
                a->vertical ? other->from - 6 : at, a->vertical ? at + 4 : other->from + 16,
                a->vertical ? "end" : "middle", k * step + 0); /* no -0 */
    }
}

static void put_frame(FILE *out, const mukca_plot *p, const axis *x, const axis *y)
{
    put_numbers(out, x, y);
    put_numbers(out, y, x);
    put_line(out, "axis", y, y->from, x);
    put_line(out, "axis", x, x->from, y);
    fprintf(out, "<text text-anchor=\"middle\" x=\"%.1f\" y=\"%d\">", (x->from + x->to) / 2,
            HEIGHT - 8);
    mukca_html_escape(out, p->label[0]);
    fprintf(out,
            "</text>\n<text text-anchor=\"middle\" transform=\"translate(14 %.1f) rotate(-90)\">",
            (y->from + y->to) / 2);
    mukca_html_escape(out, p->label[1]);
    fputs("</text>\n", out);
}

/* A disc or a cross. */
static void put_mark(FILE *out, mukca_plot_series series, double x, double y)
{
    if (series == MUKCA_PLOT_AFTER)
        fprintf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"2.2\"/>\n", x, y);
    else
        fprintf(out, "<path d=\"M%.1f %.1fm-3-3l6 6m0-6l-6 6\"/>\n", x, y);
}

/* A line through the points of a series. */
static void put_curve(FILE *out, const mukca_plot *p, int series, const axis *x, const axis *y)
{
    char next = 'M';
    fputs("<path d=\"", out);
    for (const mukca_plot_point *q = p->points; q < p->points + p->n_points; q++) {
        if ((int)q->series != series) continue;
        fprintf(out, "%c%.1f %.1f", next, place(x, q->at[0]), place(y, q->at[1]));
        next = 'L';
    }
    fputs("\"/>\n", out);
}

static void put_series(FILE *out, const mukca_plot *p, const axis *x, const axis *y)
{
    double key = x->from;
    for (int k = 0; k < MUKCA_PLOT_SERIES; k++) {
        const int s = p->lines ? MUKCA_PLOT_SERIES - 1 - k : k; /* the measured line lies below */
        fprintf(out, "<g class=\"%s\">\n", series_class[s]);
        for (const mukca_plot_point *q = p->points; q < p->points + p->n_points; q++) {
            if ((int)q->series == s && !p->lines)
                put_mark(out, q->series, place(x, q->at[0]), place(y, q->at[1]));
        }
        if (p->lines) put_curve(out, p, s, x, y);
        if (p->key[s] && p->lines)
            fprintf(out, "<path d=\"M%.1f %dh12\"/>\n", key, TOP - 18);
        else if (p->key[s])
            put_mark(out, (mukca_plot_series)s, key + 6, TOP - 18);
        fputs("</g>\n", out);
        if (!p->key[s]) continue;
        fprintf(out, "<text x=\"%.1f\" y=\"%d\">%s</text>\n", key + 14, TOP - 14, p->key[s]);
        key += 30 + LETTER * (double)strlen(p->key[s]);
    }
}

void mukca_plot_put(FILE *out, const mukca_plot *p)
{
    const axis x = find_axis(p, 0), y = find_axis(p, 1);
    fprintf(
        out,
        "<figure>\n<svg class=\"plot\" viewBox=\"0 0 %d %d\" role=\"img\" aria-labelledby=\"%s-t "
        "%s-d\">\n<title id=\"%s-t\">",
        WIDTH, HEIGHT, p->id, p->id, p->id);
    mukca_html_escape(out, p->title);
    fprintf(out, "</title>\n<desc id=\"%s-d\">", p->id);
    mukca_html_escape(out, p->words);
    fputs("</desc>\n", out);
    put_frame(out, p, &x, &y);
    put_series(out, p, &x, &y);
    fputs("</svg>\n<figcaption>", out);
    mukca_html_element(out, "strong", p->title);
    fputs("</figcaption>\n</figure>\n", out);
}
