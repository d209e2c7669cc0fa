/* The scan for gear ripple: all orders of all joints. */
#include "diagnose/ripple.h"

#include <math.h>
#include <string.h>

#define HALF_WAVE 0.70710678118654752440 /* rms of a sine */

enum { CHUNK = MUKCA_MAX_COLUMNS }; /* orders scanned together: two columns each */

double mukca_ripple_log_prior(int order)
{
    /* Ratios of strain wave and cycloidal gears in cobots, their doubles (two lobes a turn), and
     * encoder line counts that alias onto low orders. */
    static const int usual[] = {50,  51,  80,  81,  100, 101, 102, 120, 121, 128,
                                160, 161, 200, 202, 240, 242, 256, 320, 322};
    const int n_usual = (int)(sizeof usual / sizeof *usual);
    double p = 0.3 / 399;
    if (order <= 6) p += 0.4 / 5;
    for (int i = 0; i < n_usual; i++)
        if (usual[i] == order) p += 0.3 / n_usual;
    return log(p);
}

/* One long loop on purpose: an order needs two columns only, so the sums of mukca_joint_view_gram
 * are written out for many orders at once. */
void mukca_ripple_scan(double *value, const mukca_joint_view *view, double *mean, double *waves)
{
    const mukca_projector *p = view->p;
    const mukca_regression *m = p->m;
    const int n = p->n, n_joints = m->recording.chain->n_joints, rows = m->recording.n_samples;
    double *sine = waves, *cosine = sine + rows, *s1 = cosine + rows, *c1 = s1 + rows;
    const mukca_candidate h = {.kind = MUKCA_CANDIDATE_EFFECT,
                               .joint = view->joint,
                               .effect = {.kind = MUKCA_EFFECT_GEAR_HARMONIC},
                               .terms = 2,
                               .unit = {HALF_WAVE, HALF_WAVE}};
    for (int i = 0; i < rows; i++) {
        const double q = m->recording.data->q[m->recording.order[i] * n_joints + view->joint];
        s1[i] = sine[i] = sin(q), c1[i] = cosine[i] = cos(q);
    }
    for (int start = 2; start <= MUKCA_RIPPLE_ORDERS; start += CHUNK) {
        const int count =
            MUKCA_RIPPLE_ORDERS + 1 - start < CHUNK ? MUKCA_RIPPLE_ORDERS + 1 - start : CHUNK;
        const int width = 2 * count;
        double g[2 * CHUNK], same[2 * CHUNK] = {0}, cross[CHUNK] = {0};
        double lost[2 * CHUNK] = {0}, lost_cross[CHUNK] = {0};
        for (int i = 0; i < rows; i++) { /* the waves by the recurrence of the addition theorem */
            double s = sine[i], c = cosine[i], *f = view->F + (size_t)i * (size_t)width;
            for (int o = 0; o < count; o++) {
                const double next = s * c1[i] + c * s1[i];
                c = c * c1[i] - s * s1[i];
                s = next;
                f[2 * o] = s, f[2 * o + 1] = c;
            }
            sine[i] = s, cosine[i] = c;
        }
        mukca_joint_view_project(g, mean, view, width);
        for (int i = 0; i < rows; i++) {
            const double *f = view->F + (size_t)i * (size_t)width;
            const double *x = view->H + (size_t)i * (size_t)width;
            for (int k = 0; k < width; k++) same[k] += x[k] * f[k];
            for (int o = 0; o < count; o++)
                cross[o] += 0.5 * (x[2 * o] * f[2 * o + 1] + x[2 * o + 1] * f[2 * o]);
        }
        for (int e = 0; e < m->recording.n_groups; e++)
            for (int c = 0; c < 3 && m->recording.groups[e].socket >= 0; c++) {
                const double *x = mean + (3 * e + c) * width;
                for (int k = 0; k < width; k++) same[k] -= p->weights[e] * x[k] * x[k];
                for (int o = 0; o < count; o++) cross[o] -= p->weights[e] * x[2 * o] * x[2 * o + 1];
            }
        for (int r = 0; r < m->recording.n_pairs; r++) {
            const mukca_socket_pair *pair = &m->recording.pairs[r];
            const double w = p->inverse[r] / p->precision;
            double along[2 * CHUNK] = {0};
            for (int c = 0; c < 3; c++)
                for (int k = 0; k < width; k++)
                    along[k] += m->linear.direction[r][c] * (mean[(3 * pair->a + c) * width + k] -
                                                             mean[(3 * pair->b + c) * width + k]);
            for (int k = 0; k < width; k++) same[k] += w * along[k] * along[k];
            for (int o = 0; o < count; o++) cross[o] += w * along[2 * o] * along[2 * o + 1];
        }
        for (int k = 0; k < n; k++) {
            const double *t = p->T + k * width;
            for (int e = 0; e < width; e++) lost[e] += t[e] * t[e];
            for (int o = 0; o < count; o++) lost_cross[o] += t[2 * o] * t[2 * o + 1];
        }
        for (int o = 0; o < count; o++) {
            const double off = p->precision * cross[o] - lost_cross[o];
            double G[4] = {p->precision * same[2 * o] - lost[2 * o], off, off,
                           p->precision * same[2 * o + 1] - lost[2 * o + 1]};
            double gradient[2] = {g[2 * o], g[2 * o + 1]};
            value[start + o] =
                mukca_projector_block(G, gradient, &h, p->residual, p->normal->dof, NULL);
        }
    }
}
