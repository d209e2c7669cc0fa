/* The arm in the posture of the first sample, with the findings where they are. */
#include <math.h>

#include "report/report.h"

/* Widths of a finding's line for none and all of what is explained, pixels. */
static const double thin = 10, thick = 30;

/* Direction of view, rad. */
static const double azimuth = 0.6, elevation = 0.4;

/* The arm as it is seen: its vertices from base to tip, mm to the right and down. */
typedef struct {
    int n;
    double at[MUKCA_MAX_ELEMENTS + 1][2];
} view;

static void find_vertices(view *v, const mukca_report *r)
{
    mukca_frame frame[MUKCA_MAX_ELEMENTS + 1];
    const double c = cos(azimuth), s = sin(azimuth), e = cos(elevation), f = sin(elevation);
    *v = (view){.n = r->fitted->n_elements + 1};
    mukca_fk_frames(frame, &frame[v->n - 1], &r->geometry, r->train->q, NULL);
    for (int k = 0; k < v->n; k++) {
        const double *p = frame[k].p;
        v->at[k][0] = 1e3 * (p[1] * c - p[0] * s);
        v->at[k][1] = 1e3 * ((p[0] * c + p[1] * s) * f - p[2] * e);
    }
}

/* Write the line through the vertices from one to another; a dot if they are equal. */
static void put_line(FILE *out, const view *v, const char *style, int from, int to)
{
    fprintf(out, "<polyline class=\"%s\" points=\"%.1f,%.1f", style, v->at[from][0],
            v->at[from][1]);
    for (int k = from == to ? to : from + 1; k <= to; k++)
        fprintf(out, " %.1f,%.1f", v->at[k][0], v->at[k][1]);
    fputs("\"/>\n", out);
}

/* Vertex of the arm at a position of a finding. */
static int vertex_at(const mukca_chain *chain, int position)
{
    return position < 0                  ? 0
           : position == chain->n_joints ? chain->n_elements
                                         : chain->joint_element[position];
}

/* Draw a finding: where, how large, and by colour what it varies with. */
static void put_finding(FILE *out, const view *v, const mukca_report *r, const mukca_finding *f)
{
    char style[64];
    snprintf(style, sizeof style, "found v%d\" style=\"stroke-width:%.1f", f->group.family + 1,
             thin + (thick - thin) * fmin(fmax(f->share, 0), 1));
    put_line(out, v, style, vertex_at(r->fitted, f->group.from), vertex_at(r->fitted, f->group.to));
}

void mukca_report_put_view(FILE *out, const void *content)
{
    const mukca_report *r = content;
    const mukca_diagnosis *d = r->diagnosed.diagnosis;
    const double margin = 60; /* mm, for the width of the lines */
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
    const char *before = "";
    view v;
    find_vertices(&v, r);
    for (int k = 0; k < v.n; k++)
        for (int i = 0; i < 2; i++) {
            low[i] = fmin(low[i], v.at[k][i] - margin);
            high[i] = fmax(high[i], v.at[k][i] + margin);
        }
    fprintf(out,
            "<figure>\n<svg class=\"view\" role=\"img\" aria-labelledby=\"view-t view-d\" "
            "viewBox=\"%.0f %.0f %.0f %.0f\">\n<title id=\"view-t\">The arm and the places of the "
            "findings</title>\n<desc id=\"view-d\">The arm in the posture of the first sample, "
            "with each finding at its place, the wider the larger.</desc>\n",
            low[0], low[1], high[0] - low[0], high[1] - low[1]);
    put_line(out, &v, "arm", 0, v.n - 1);
    for (int i = 0; i < d->n_findings; i++)
        if (!d->findings[i].group.apart) put_finding(out, &v, r, &d->findings[i]);
    fputs(
        "</svg>\n<figcaption><strong>Findings on the arm, in the posture of the first sample, the "
        "wider the larger</strong> ",
        out);
    for (int i = 0; i < d->n_findings; i++) {
        if (d->findings[i].group.apart) continue;
        fprintf(out, "%s<span class=\"v%d\">&#9632;</span> ", before,
                d->findings[i].group.family + 1);
        mukca_html_escape(out, mukca_wording_finding(MUKCA_WORDS, &d->findings[i], &r->diagnosed));
        before = ", ";
    }
    fputs("</figcaption>\n</figure>\n", out);
}
