/* View of the arm with the errors of its tip, magnified, and the findings where they are: an SVG
 * that a small script turns. */
#include <math.h>
#include <string.h>

#include "report/page.h"
#include "report/report.h"

enum { POSTURES = 5, ERRORS = 200 };

/* Widths of a finding's line for none and all of what is explained, pixels. */
static const double thin = 10, thick = 30;

/* Initial direction of view, rad. */
static const double azimuth = 0.6, elevation = 0.4;

static const char script[] =
    "<script>for(const s of document.querySelectorAll('svg.view')){let a=+s.dataset.a,"
    "b=+s.dataset.b,d=null;const turn=(x,y)=>{a-=x;b=Math.max(-1.57,Math.min(1.57,b+y));"
    "const c=Math.cos(a),n=Math.sin(a),e=Math.cos(b),f=Math.sin(b);"
    "for(const l of s.querySelectorAll('[data-p]'))l.setAttribute('points',l.dataset.p.split(' ')"
    ".map(t=>{const[x,y,z]=t.split(',');return(y*c-x*n).toFixed(1)+','+((x*c+y*n)*f-z*e).toFixed(1)"
    "}).join(' '))};s.onpointerdown=e=>{d=e;s.setPointerCapture(e.pointerId)};"
    "s.onpointerup=s.onpointercancel=()=>{d=null};s.onpointermove=e=>{if(d){"
    "turn((e.clientX-d.clientX)/150,(e.clientY-d.clientY)/150);d=e}};s.onkeydown=e=>{"
    "const k={ArrowLeft:[.1,0],ArrowRight:[-.1,0],ArrowUp:[0,-.1],ArrowDown:[0,.1]}[e.key];"
    "if(k){e.preventDefault();turn(...k)}}}</script>\n";

/* Write a line through points[n][3], m, relative to `centre`: in space for the script, and as it is
 * seen at first. */
static void put_line(FILE *out, const char *style, double points[][3], int n,
                     const double centre[3])
{
    const double c = cos(azimuth), s = sin(azimuth), e = cos(elevation), f = sin(elevation);
    fprintf(out, "<polyline class=\"%s\" data-p=\"", style);
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < 3; k++) points[i][k] = (points[i][k] - centre[k]) * MUKCA_REPORT_MM;
        fprintf(out, "%s%.1f,%.1f,%.1f", i ? " " : "", points[i][0], points[i][1], points[i][2]);
    }
    fputs("\" points=\"", out);
    for (int i = 0; i < n; i++) {
        const double *p = points[i];
        fprintf(out, "%s%.1f,%.1f", i ? " " : "", p[1] * c - p[0] * s,
                (p[0] * c + p[1] * s) * f - p[2] * e);
    }
    fputs("\"/>\n", out);
}

/* Joints of the arm in the posture of a sample; returns their number. */
static int find_joints(double points[][3], const mukca_report *r, int row)
{
    mukca_frame before[MUKCA_MAX_ELEMENTS], tip;
    const double *q = r->train->q + row * r->train->n_joints;
    const int n = r->fitted->n_elements;
    mukca_fk_frames(before, &tip, &r->geometry, q, NULL);
    for (int k = 0; k < n; k++) memcpy(points[k], before[k].p, sizeof points[k]);
    memcpy(points[n], tip.p, sizeof tip.p);
    return n + 1;
}

/* Vertex of a line of the arm at a position of a finding. */
static int vertex_at(const mukca_chain *chain, int position)
{
    return position < 0                  ? 0
           : position == chain->n_joints ? chain->n_elements
                                         : chain->joint_element[position];
}

/* Is a finding at a place of the arm that the view shows? */
static bool is_placed(const mukca_finding *f)
{
    return !f->group.apart;
}

/* Draw the findings on the first posture: where, how large, and by colour what they vary with. */
static void put_findings(FILE *out, const mukca_report *r, const double centre[3])
{
    const mukca_diagnosis *d = r->diagnosed.diagnosis;
    double points[MUKCA_MAX_ELEMENTS + 1][3], stretch[MUKCA_MAX_ELEMENTS + 1][3];
    find_joints(points, r, 0);
    for (int i = 0; d && i < d->n_findings; i++) {
        const mukca_finding_group *g = &d->findings[i].group;
        char style[64];
        int n = 0;
        if (!is_placed(&d->findings[i])) continue;
        for (int k = vertex_at(r->fitted, g->from); k <= vertex_at(r->fitted, g->to); k++)
            memcpy(stretch[n++], points[k], sizeof *stretch);
        if (n == 1) memcpy(stretch[n++], stretch[0], sizeof *stretch); /* a dot */
        snprintf(style, sizeof style, "found v%d\" style=\"stroke-width:%.1f", g->family + 1,
                 thin + (thick - thin) * fmin(fmax(d->findings[i].share, 0), 1));
        put_line(out, style, stretch, n, centre);
    }
}

/* List them below. */
static void put_legend(FILE *out, const mukca_report *r)
{
    const mukca_diagnosis *d = r->diagnosed.diagnosis;
    const char *before = " Findings, at their place in one posture, the wider the larger: ";
    for (int i = 0; d && i < d->n_findings; i++) {
        if (!is_placed(&d->findings[i])) continue;
        fprintf(out, "%s<span class=\"v%d\">&#9632;</span> ", before,
                d->findings[i].group.family + 1);
        mukca_html_escape(out, mukca_wording_finding(MUKCA_WORDS, &d->findings[i], &r->diagnosed));
        before = ", ";
    }
    if (*before == ',') fputs(".", out);
}

void mukca_report_put_view(FILE *out, const void *content)
{
    const mukca_report *r = content;
    const int rows = r->train->n_rows;
    double points[MUKCA_MAX_ELEMENTS + 1][3], low[3], high[3], centre[3], most = 0, reach = 0;
    for (int k = 0; k < 3; k++) low[k] = HUGE_VAL, high[k] = -HUGE_VAL;
    for (int i = 0; i < POSTURES; i++)
        for (int n = find_joints(points, r, i * rows / POSTURES) - 1; n >= 0; n--)
            for (int k = 0; k < 3; k++) {
                low[k] = fmin(low[k], points[n][k]);
                high[k] = fmax(high[k], points[n][k]);
            }
    for (int k = 0; k < 3; k++) {
        centre[k] = (low[k] + high[k]) / 2;
        reach += pow((high[k] - low[k]) / 2, 2);
    }
    reach = 1.05 * sqrt(reach);
    for (int i = 0; i < rows; i++) most = fmax(most, r->evaluation[MUKCA_NOMINAL].error[i]);
    if (!(most > 0)) return;
    const char *const where = r->train->n_sockets > 0 ? "mean of its socket" : "measured position";
    const double scale = mukca_plot_round(0.3 * reach / most);
    fprintf(
        out,
        "<figure>\n<svg class=\"view\" tabindex=\"0\" role=\"img\" aria-labelledby=\"view-t "
        "view-d\" "
        "viewBox=\"%.0f %.0f %.0f %.0f\" data-a=\"%g\" data-b=\"%g\">\n<title id=\"view-t\">The "
        "arm and the errors of its tip</title>\n<desc id=\"view-d\">The arm in %d postures, with "
        "the error of each sample from the %s, nominal and calibrated, times %g.</desc>\n",
        -1e3 * reach, -1e3 * reach, 2e3 * reach, 2e3 * reach, azimuth, elevation, POSTURES, where,
        scale);
    for (int i = 0; i < POSTURES; i++) {
        const int n = find_joints(points, r, i * rows / POSTURES);
        put_line(out, "arm", points, n, centre);
    }
    put_findings(out, r, centre);
    for (int m = 0; m < MUKCA_REPORT_MODELS; m += MUKCA_CALIBRATED)
        for (int i = 0; i < rows; i += 1 + rows / ERRORS) {
            const double *tip = r->evaluation[m].tips[i].p,
                         *from = mukca_evaluation_centre(&r->evaluation[m], r->train, i);
            if (!isfinite(r->evaluation[m].error[i])) continue;
            for (int k = 0; k < 3; k++) {
                points[0][k] = from[k];
                points[1][k] = from[k] + scale * (tip[k] - from[k]);
            }
            put_line(out, m ? "after" : "before", points, 2, centre);
        }
    fprintf(
        out,
        "</svg>\n<figcaption><strong>The arm in %d postures, errors times %g</strong> Error of "
        "each sample from the %s: nominal in orange, calibrated in blue. Drag to turn, or use the "
        "arrow keys.",
        POSTURES, scale, where);
    put_legend(out, r);
    fprintf(out, "</figcaption>\n</figure>\n%s", script);
}
