/* Score every candidate cause against the present model.
 *
 * With the present columns X (geometry and causes, prior sigmas D) and H = 1 + D X'WX D = LL', a
 * candidate E with W the whitening and centring (and the distance rows) has the projected normal
 * equations  G = E'WE - T'T,  g = E'u,  T = L^-1 D X'W E,  u = W y - (L^-1 D X'W)' z.  So W X is
 * formed once, and each candidate costs one product with it.
 */
#include "study/scan.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "math/stats.h"

typedef struct {
    gap_model *m;
    const gap_pack *pack;
    int n, rows;         /* columns; observation rows d * m->n */
    double precision;    /* 1 / sigma^2 */
    double *inverse;     /* [n_pairs] 1 / variance of the distance rows */
    double *z;           /* [n] */
    double *Q;           /* [rows][n + 1]: W X and W y */
    double *Zt;          /* [rows][n] */
    double *u;           /* [rows] */
    double *mean_weight; /* [m->n] weight of each kept row in its socket's whitened mean */
    double *weights;     /* [n_groups] o'o */
    double residual;     /* quadratic form that the present model leaves */
    double *E, *white;   /* [rows][GAP_MAX_TERMS] */
    double *T;           /* [n][2 * chunk] */
} projector;

enum { CHUNK = 32 }; /* harmonics scanned together */

/* Coefficients of row i of n in the inner AR(1) whitening: own and previous. */
static inline void ar_row(double *own, double *before, int i, double rho)
{
    const double r1 = sqrt(1 - rho * rho);
    *own = i ? 1 / r1 : 1;
    *before = i ? rho / r1 : 0;
}

static void prepare(projector *p)
{
    const gap_model *m = p->m;
    const int d = m->dim, n = p->n, size = n + 1;
    const double rho = p->pack->rho, sigma2 = 1 / p->precision;
    const double *L = m->posterior_chol;
    const double sd2 = m->options.distance_sigma * m->options.distance_sigma;
    for (int k = 0; k < m->n_pairs; k++) p->inverse[k] = 1 / (sd2 + sigma2 * p->pack->variance[k]);
    for (int g = 0; g < m->n_groups; g++) {
        const gap_group *group = &m->groups[g];
        double sum = 0;
        for (int i = 0; i < group->count; i++) {
            double own, before;
            ar_row(&own, &before, i, rho);
            sum += (own - before) * (own - before);
        }
        p->weights[g] = sum;
        for (int i = 0; i < group->count; i++) {
            double own, before, next_own, next_before, w;
            ar_row(&own, &before, i, rho);
            ar_row(&next_own, &next_before, i + 1, rho);
            w = own * (own - before);
            if (i + 1 < group->count) w -= next_before * (next_own - next_before);
            p->mean_weight[group->start + i] = w / sum;
            for (int c = 0; c < d; c++) {
                const size_t at = (size_t)((group->start + i) * d + c) * (size_t)size;
                const double *white = p->pack->white + at;
                double *q = p->Q + at;
                const double a = p->precision * own, b = p->precision * next_before;
                if (i + 1 < group->count && rho > 0) {
                    const double *next = white + (size_t)d * (size_t)size;
                    for (int k = 0; k < size; k++) q[k] = a * white[k] - b * next[k];
                } else {
                    for (int k = 0; k < size; k++) q[k] = a * white[k];
                }
            }
        }
    }
    for (int k = 0; k < m->n_pairs; k++) {
        const gap_pair *pair = &m->pairs[k];
        const double *row = p->pack->distance + k * size;
        for (int side = 0; side < 2; side++) {
            const gap_group *group = &m->groups[side ? pair->b : pair->a];
            for (int i = group->start; i < group->start + group->count; i++)
                for (int c = 0; c < 3; c++) {
                    const double w =
                        (side ? -1 : 1) * p->inverse[k] * pair->direction[c] * p->mean_weight[i];
                    double *q = p->Q + (size_t)(i * d + c) * (size_t)size;
                    for (int e = 0; e < size; e++) q[e] += w * row[e];
                }
        }
    }
    /* Zt := (L^-1 D Q')', row by row; u := W y - Zt z.  Columns with prior 0 drop out. */
    for (int r = 0; r < p->rows; r++) {
        const double *q = p->Q + (size_t)r * (size_t)size;
        double *x = p->Zt + (size_t)r * (size_t)n, sum = q[n];
        for (int i = 0; i < n; i++) x[i] = q[i] * m->prior[i];
        for (int i = 0; i < n; i++) {
            const double *l = L + i * n;
            double s0 = x[i], s1 = 0;
            int k = 0;
            for (; k + 1 < i; k += 2) s0 -= l[k] * x[k], s1 -= l[k + 1] * x[k + 1];
            if (k < i) s0 -= l[k] * x[k];
            x[i] = (s0 + s1) / l[i];
        }
        for (int i = 0; i < n; i++) sum -= x[i] * p->z[i];
        p->u[r] = sum;
    }
}

/* Log Bayes factor of a block with projected Gram G[k][k] and gradient g[k] (both destroyed),
 * averaged over prior scales; noise profiled, sign of the first coefficient honoured. */
static double block_log_bayes(double *G, double *g, const gap_hypothesis *h, double residual,
                              int dof, double *information)
{
    const int k = h->terms;
    double A[GAP_MAX_TERMS * GAP_MAX_TERMS], x[GAP_MAX_TERMS], first[GAP_MAX_TERMS];
    double value[8];
    const double *scales;
    const int n_scales = gap_scales(&scales, h);
    const bool nonnegative =
        h->kind == GAP_EFFECT && mukca_effect_table[h->effect.kind].nonnegative;
    double trace = 0;
    for (int i = 0; i < k; i++) {
        g[i] /= h->unit[i];
        for (int j = 0; j < k; j++) G[i * k + j] /= h->unit[i] * h->unit[j];
    }
    for (int i = 0; i < k; i++) trace = fmax(trace, G[i * k + i]);
    if (information) *information = trace;
    for (int s = 0; s < n_scales; s++) {
        const double s2 = scales[s] * scales[s];
        double log_det = 0, q = 0;
        for (int i = 0; i < k; i++) {
            for (int j = 0; j <= i; j++) A[i * k + j] = s2 * 0.5 * (G[i * k + j] + G[j * k + i]);
            A[i * k + i] += 1;
        }
        if (mukca_dense_cholesky(A, k)) return -HUGE_VAL;
        for (int i = 0; i < k; i++) x[i] = g[i];
        mukca_dense_forward(x, 1, A, k);
        for (int i = 0; i < k; i++) {
            log_det += 2 * log(A[i * k + i]);
            q += s2 * x[i] * x[i];
        }
        q = fmin(q, 0.9999 * residual);
        value[s] = -0.5 * log_det - 0.5 * dof * log1p(-q / residual);
        if (nonnegative) {
            mukca_dense_backward(x, 1, A, k);
            memset(first, 0, sizeof *first * (size_t)k);
            first[0] = 1;
            mukca_dense_forward(first, 1, A, k);
            double variance = 0;
            for (int i = 0; i < k; i++) variance += s2 * first[i] * first[i];
            variance *= fmax((residual - q) / dof, 1e-6);
            value[s] += log(2) + mukca_stats_log_normal_cdf(s2 * x[0] / sqrt(variance));
        }
    }
    return mukca_stats_log_sum_exp(value, n_scales) - log(n_scales);
}

/* G := E'WE - T'T and g := E'u of k columns E[rows][k]. */
static void project(double *G, double *g, projector *p, const double *E, int k,
                    const gap_hypothesis *h)
{
    const gap_model *m = p->m;
    const int d = m->dim, n = p->n;
    double along[GAP_MAX_TERMS];
    memset(G, 0, sizeof *G * (size_t)(k * k));
    memset(g, 0, sizeof *g * (size_t)k);
    memset(p->T, 0, sizeof *p->T * (size_t)(n * k));
    for (int e = 0; e < m->n_groups; e++) {
        const gap_group *group = &m->groups[e];
        for (int i = 0; i < group->count; i++) {
            double own, before;
            ar_row(&own, &before, i, p->pack->rho);
            for (int c = 0; c < d; c++) {
                const size_t at = (size_t)((group->start + i) * d + c) * (size_t)k;
                for (int t = 0; t < k; t++)
                    p->white[at + (size_t)t] =
                        own * E[at + (size_t)t] -
                        (i ? before * E[at - (size_t)(d * k) + (size_t)t] : 0);
            }
        }
    }
    mukca_dense_syrk(G, k, p->white, p->rows, k);
    for (int i = 0; i < k * k; i++) G[i] *= p->precision;
    /* Sockets' means: out of the rows, into the distance rows. */
    double mean[GAP_MAX_TERMS];
    for (int e = 0; e < m->n_groups; e++) {
        const gap_group *group = &m->groups[e];
        if (group->socket < 0) continue;
        for (int c = 0; c < 3; c++) {
            memset(mean, 0, sizeof mean);
            for (int i = group->start; i < group->start + group->count; i++)
                for (int t = 0; t < k; t++) mean[t] += p->mean_weight[i] * E[(i * d + c) * k + t];
            const double w = p->precision * p->weights[e];
            for (int a = 0; a < k; a++)
                for (int b = 0; b < k; b++) G[a * k + b] -= w * mean[a] * mean[b];
        }
    }
    for (int r = 0; r < m->n_pairs; r++) {
        const gap_pair *pair = &m->pairs[r];
        memset(along, 0, sizeof along);
        for (int side = 0; side < 2; side++) {
            const gap_group *group = &m->groups[side ? pair->b : pair->a];
            for (int i = group->start; i < group->start + group->count; i++)
                for (int c = 0; c < 3; c++) {
                    const double w = (side ? -1 : 1) * p->mean_weight[i] * pair->direction[c];
                    for (int t = 0; t < k; t++) along[t] += w * E[(i * d + c) * k + t];
                }
        }
        if (h->kind ==
            GAP_DISTANCE) { /* acts on the distance rows alone: what prepare() left out */
            const double *row = p->pack->distance + r * (n + 1);
            along[0] = -1;
            g[0] -= p->inverse[r] * row[n];
            for (int i = 0; i < n; i++) p->T[i] -= p->inverse[r] * row[i] * m->prior[i];
        }
        for (int a = 0; a < k; a++)
            for (int b = 0; b < k; b++) G[a * k + b] += p->inverse[r] * along[a] * along[b];
    }
    if (h->kind == GAP_DISTANCE) {
        mukca_dense_forward(p->T, 1, m->posterior_chol, n);
        for (int i = 0; i < n; i++) g[0] -= p->T[i] * p->z[i];
    } else {
        mukca_dense_xty(p->T, k, p->Zt, n, n, E, k, k, p->rows);
        for (int r = 0; r < p->rows; r++)
            for (int t = 0; t < k; t++) g[t] += E[r * k + t] * p->u[r];
    }
    for (int a = 0; a < k; a++)
        for (int b = 0; b < k; b++) {
            double sum = 0;
            for (int i = 0; i < n; i++) sum += p->T[i * k + a] * p->T[i * k + b];
            G[a * k + b] -= sum;
        }
}

/* Faults of one socket or row: columns -share(row) * identity, so sums over rows suffice. */
static double fault_log_bayes(projector *p, const gap_hypothesis *h, double *information)
{
    const gap_model *m = p->m;
    const gap_group *group = &m->groups[h->group];
    const int d = m->dim, n = p->n, first_row = m->order[group->start],
              last_row = m->order[group->start + group->count - 1];
    double T[3][512], G[9], g[3] = {0, 0, 0}, square = 0, mean = 0, last = 0;
    if (n > 512) return -HUGE_VAL;
    memset(T, 0, sizeof T);
    for (int i = 0; i < group->count; i++) {
        const int row = m->order[group->start + i];
        double own, before, share;
        if (h->kind == GAP_STEP)
            share = row >= h->row;
        else if (h->kind == GAP_SPIKE)
            share = row == h->row;
        else
            share = last_row > first_row ? (double)(row - first_row) / (last_row - first_row) : 0;
        ar_row(&own, &before, i, p->pack->rho);
        const double white = own * share - before * last;
        last = share;
        square += white * white;
        if (share == 0) continue;
        if (group->socket >= 0) mean += p->mean_weight[group->start + i] * share;
        for (int c = 0; c < 3; c++) {
            const size_t r = (size_t)((group->start + i) * d + c);
            const double *z = p->Zt + r * (size_t)n;
            for (int k = 0; k < n; k++) T[c][k] -= share * z[k];
            g[c] -= share * p->u[r];
        }
    }
    const double own_part =
        p->precision * (square - (group->socket >= 0 ? p->weights[h->group] * mean * mean : 0));
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            double sum = a == b ? own_part : 0;
            for (int k = 0; k < n; k++) sum -= T[a][k] * T[b][k];
            G[3 * a + b] = sum;
        }
    for (int r = 0; r < m->n_pairs; r++) {
        const gap_pair *pair = &m->pairs[r];
        if (pair->a != h->group && pair->b != h->group) continue;
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++)
                G[3 * a + b] +=
                    p->inverse[r] * mean * mean * pair->direction[a] * pair->direction[b];
    }
    return block_log_bayes(G, g, h, p->residual, p->pack->dof, information);
}

static double field_log_bayes(projector *p, const gap_hypothesis *h, double *information)
{
    double G[GAP_MAX_TERMS * GAP_MAX_TERMS], g[GAP_MAX_TERMS];
    gap_hypothesis_columns(p->E, h->terms, p->m, h);
    project(G, g, p, p->E, h->terms, h);
    return block_log_bayes(G, g, h, p->residual, p->pack->dof, information);
}

/* All orders 2 .. 400 of one joint: value[order] = log Bayes factor.  The joint's levers turn the
 * three rows of a sample into one, and the waves come from a recurrence. */
static void harmonic_scan(double *value, projector *p, int joint, double *Zj, double *waves)
{
    const gap_model *m = p->m;
    const int d = m->dim, n = p->n, n_joints = m->chain->n_joints, rows = m->n;
    const double rho = p->pack->rho;
    double *uj = waves, *sine = uj + rows, *cosine = sine + rows, *s1 = cosine + rows,
           *c1 = s1 + rows, *F = c1 + rows; /* F[rows][2 * CHUNK] */
    gap_hypothesis h = {.kind = GAP_EFFECT,
                        .effect = {.kind = MUKCA_EFFECT_GEAR_HARMONIC, .joint = joint},
                        .terms = 2,
                        .unit = {0.70710678118654752440, 0.70710678118654752440}};
    memset(Zj, 0, sizeof *Zj * (size_t)(rows * n));
    for (int i = 0; i < rows; i++) {
        const double *lever = m->lever + (size_t)(i * n_joints + joint) * (size_t)d;
        const double q = m->data->q[m->order[i] * n_joints + joint];
        uj[i] = 0;
        for (int c = 0; c < d; c++) {
            const double *z = p->Zt + (size_t)(i * d + c) * (size_t)n;
            for (int k = 0; k < n; k++) Zj[(size_t)i * (size_t)n + (size_t)k] += lever[c] * z[k];
            uj[i] += lever[c] * p->u[i * d + c];
        }
        s1[i] = sin(q), c1[i] = cos(q);
        sine[i] = s1[i], cosine[i] = c1[i];
    }
    for (int start = 2; start <= 400; start += CHUNK) {
        const int count = 401 - start < CHUNK ? 401 - start : CHUNK, width = 2 * count;
        for (int i = 0; i < rows; i++) {
            double s = sine[i], c = cosine[i], *f = F + (size_t)i * (size_t)width;
            for (int o = 0; o < count; o++) {
                const double next = s * c1[i] + c * s1[i];
                c = c * c1[i] - s * s1[i];
                s = next;
                f[2 * o] = s, f[2 * o + 1] = c;
            }
            sine[i] = s, cosine[i] = c;
        }
        memset(p->T, 0, sizeof *p->T * (size_t)(n * width));
        mukca_dense_xty(p->T, width, Zj, n, n, F, width, width, rows);
        double square[2 * CHUNK] = {0}, product[CHUNK] = {0}, g[2 * CHUNK] = {0};
        double mean[3][2 * CHUNK];
        for (int e = 0; e < m->n_groups; e++) {
            const gap_group *group = &m->groups[e];
            memset(mean, 0, sizeof mean);
            for (int i = 0; i < group->count; i++) {
                const int at = group->start + i;
                const double *lever = m->lever + (size_t)(at * n_joints + joint) * (size_t)d;
                const double *last = lever - (size_t)(n_joints * d);
                const double *f = F + (size_t)at * (size_t)width;
                double own, before, next_own, next_before, diagonal = 0, off = 0;
                ar_row(&own, &before, i, rho);
                ar_row(&next_own, &next_before, i + 1, rho);
                for (int c = 0; c < d; c++) diagonal += lever[c] * lever[c];
                diagonal *= own * own + (i + 1 < group->count ? next_before * next_before : 0);
                if (i && rho > 0) {
                    for (int c = 0; c < d; c++) off += lever[c] * last[c];
                    off *= -2 * own * before;
                    const double *fb = f - width;
                    for (int k = 0; k < width; k++)
                        square[k] += f[k] * (diagonal * f[k] + off * fb[k]);
                    for (int o = 0; o < count; o++)
                        product[o] +=
                            diagonal * f[2 * o] * f[2 * o + 1] +
                            0.5 * off * (f[2 * o] * fb[2 * o + 1] + f[2 * o + 1] * fb[2 * o]);
                } else {
                    for (int k = 0; k < width; k++) square[k] += diagonal * f[k] * f[k];
                    for (int o = 0; o < count; o++)
                        product[o] += diagonal * f[2 * o] * f[2 * o + 1];
                }
                for (int k = 0; k < width; k++) g[k] += uj[at] * f[k];
                for (int c = 0; c < 3; c++) {
                    const double w = p->mean_weight[at] * lever[c];
                    for (int k = 0; k < width; k++) mean[c][k] += w * f[k];
                }
            }
            if (group->socket < 0) continue;
            for (int c = 0; c < 3; c++) {
                for (int k = 0; k < width; k++)
                    square[k] -= p->weights[e] * mean[c][k] * mean[c][k];
                for (int o = 0; o < count; o++)
                    product[o] -= p->weights[e] * mean[c][2 * o] * mean[c][2 * o + 1];
            }
        }
        double t2[2 * CHUNK] = {0}, tt[CHUNK] = {0};
        for (int k = 0; k < n; k++) {
            const double *t = p->T + k * width;
            for (int e = 0; e < width; e++) t2[e] += t[e] * t[e];
            for (int o = 0; o < count; o++) tt[o] += t[2 * o] * t[2 * o + 1];
        }
        for (int o = 0; o < count; o++) {
            double G[4] = {p->precision * square[2 * o] - t2[2 * o],
                           p->precision * product[o] - tt[o], 0,
                           p->precision * square[2 * o + 1] - t2[2 * o + 1]};
            G[2] = G[1];
            double gradient[2] = {g[2 * o], g[2 * o + 1]};
            value[start + o] = block_log_bayes(G, gradient, &h, p->residual, p->pack->dof, NULL);
        }
    }
}

const gap_hypothesis *gap_scan_hypothesis(const gap_scan *scan, int index)
{
    return index < scan->all->count ? &scan->all->list[index]
                                    : &scan->harmonic[index - scan->all->count];
}

/* The best orders of each joint join the candidates. */
static void pick_harmonics(gap_scan *scan, projector *p)
{
    const gap_model *m = p->m;
    const int n_joints = m->chain->n_joints;
    double *Zj = p->Q; /* free once Zt is there */
    scan->n_harmonic = 0;
    for (int j = 0; j < n_joints; j++) {
        double value[401], lo = HUGE_VAL, hi = -HUGE_VAL;
        const mukca_element *element = &m->chain->element[m->chain->joint_element[j]];
        for (int i = 0; i < m->n; i++) {
            lo = fmin(lo, m->data->q[m->order[i] * n_joints + j]);
            hi = fmax(hi, m->data->q[m->order[i] * n_joints + j]);
        }
        if (element->type == MUKCA_PRISMATIC || hi - lo < 1e-2) continue;
        harmonic_scan(value, p, j, Zj, p->white);
        for (int order = 2; order <= 400; order++) value[order] += gap_order_log_prior(order);
        for (int k = 0; k < GAP_HARMONICS_KEPT; k++) {
            int best = 2;
            for (int order = 3; order <= 400; order++)
                if (value[order] > value[best]) best = order;
            gap_hypothesis *h = &scan->harmonic[scan->n_harmonic];
            *h = (gap_hypothesis){.kind = GAP_EFFECT,
                                  .effect = {.kind = MUKCA_EFFECT_GEAR_HARMONIC,
                                             .joint = j,
                                             .placement = -1,
                                             .variant = best,
                                             .terms = 2},
                                  .terms = 2,
                                  .width = 1,
                                  .unit = {0.70710678118654752440, 0.70710678118654752440}};
            h->basis =
                scan->harmonic_basis + (size_t)scan->n_harmonic * (size_t)m->data->n_rows * 2;
            for (int row = 0; row < m->data->n_rows; row++) {
                const double q = m->data->q[row * n_joints + j];
                h->basis[2 * row] = (float)sin(best * q);
                h->basis[2 * row + 1] = (float)cos(best * q);
            }
            h->log_prior = gap_order_log_prior(best) - log(n_joints) - log(scan->all->classes);
            value[best] = -HUGE_VAL;
            scan->n_harmonic++;
        }
    }
}

/* Lay the projector out in the scan's memory. */
static projector lay_out(gap_scan *scan, gap_model *m)
{
    projector p = {.m = m, .n = m->n_columns, .rows = m->n * m->dim};
    double *at = scan->memory;
    p.inverse = at, at += m->n_pairs + 1;
    p.weights = at, at += m->n_groups + 1;
    p.z = at, at += p.n;
    p.mean_weight = at, at += m->n;
    p.u = at, at += p.rows;
    p.Q = at, at += (size_t)p.rows * (size_t)(p.n + 1);
    p.Zt = at, at += (size_t)p.rows * (size_t)p.n;
    p.E = at, at += (size_t)p.rows * GAP_MAX_TERMS;
    p.white = at, at += (size_t)p.rows * GAP_MAX_TERMS;
    p.T = at;
    return p;
}

/* Prior sigmas with one cause taken out: a prior of width 0 does that. */
static void leave_out(gap_model *m, int without)
{
    gap_model_prior(m->prior, m, -1);
    if (without < 0) return;
    int column = m->n_geometry;
    for (int c = 0; c < without; c++) column += m->cause[c].hypothesis.terms;
    for (int t = 0; t < m->cause[without].hypothesis.terms; t++) m->prior[column + t] = 0;
}

/* Make the projector ready for one rho, whose pack is filled. */
static void aim(projector *p, gap_model *m, const gap_pack *pack, double sigma)
{
    const int n = p->n;
    p->pack = pack;
    p->precision = 1 / (sigma * sigma);
    gap_model_evidence(m, pack, m->prior, sigma, NULL);
    memcpy(p->z, m->work, sizeof *p->z * (size_t)n);
    p->residual = p->precision * pack->gram[(size_t)(n + 1) * (size_t)(n + 1) - 1];
    prepare(p);
    for (int k = 0; k < m->n_pairs; k++) {
        const double y = pack->distance[k * (n + 1) + n];
        p->residual += p->inverse[k] * y * y;
    }
    for (int k = 0; k < n; k++) p->residual -= p->z[k] * p->z[k];
    p->residual = fmax(p->residual, 1e-9);
}

void gap_scan_run(gap_scan *scan, gap_model *m, int without)
{
    projector p = lay_out(scan, m);
    const int count = scan->all->count;
    double value[GAP_RHOS], sigma[GAP_RHOS];
    int order[GAP_RHOS] = {0, 1, 2};
    leave_out(m, without);
    for (int i = 0; i < GAP_RHOS; i++) {
        gap_model_pack(&m->pack[i], m, gap_rho[i]);
        sigma[i] = gap_model_best_sigma(m, &m->pack[i], m->prior, &value[i]);
        if (without >= 0) { /* the noise is what the full model leaves, not what the hole adds */
            sigma[i] = fmin(sigma[i], 1.15 * m->sigma);
            value[i] = gap_model_evidence(m, &m->pack[i], m->prior, sigma[i], NULL);
        }
    }
    for (int i = 1; i < GAP_RHOS; i++) /* best rho first: the harmonics are picked there */
        if (value[i] > value[order[0]]) order[i] = order[0], order[0] = i;
    const double total = mukca_stats_log_sum_exp(value, GAP_RHOS);

    scan->n_harmonic = 0;
    for (int i = 0; i < GAP_RHOS; i++) {
        const int which = order[i];
        aim(&p, m, &m->pack[which], sigma[which]);
        if (i == 0) {
            scan->rho = which, scan->sigma = sigma[which];
            if (scan->all->harmonics) pick_harmonics(scan, &p);
            scan->n_scores = count + scan->n_harmonic;
        }
        for (int k = 0; k < scan->n_scores; k++) {
            const gap_hypothesis *h = gap_scan_hypothesis(scan, k);
            const bool fault = h->kind == GAP_STEP || h->kind == GAP_CREEP || h->kind == GAP_SPIKE;
            const bool gone = fault && (!m->groups[h->group].count || !m->keep[h->row]);
            double information = 0;
            const double log_bayes = gone    ? -HUGE_VAL
                                     : fault ? fault_log_bayes(&p, h, &information)
                                             : field_log_bayes(&p, h, &information);
            gap_score *score = &scan->score[k];
            const double weighted = log_bayes + value[which] - total;
            if (i == 0)
                *score = (gap_score){k, weighted, 0, information};
            else if (weighted > score->log_bayes)
                score->log_bayes = weighted + log1p(exp(score->log_bayes - weighted));
            else if (score->log_bayes > -HUGE_VAL)
                score->log_bayes += log1p(exp(weighted - score->log_bayes));
        }
    }
    for (int k = 0; k < scan->n_scores; k++)
        scan->score[k].log_odds =
            scan->score[k].log_bayes + gap_scan_hypothesis(scan, k)->log_prior;
}

/* Columns that stand for a hypothesis when two are compared: elastic ones by their sum of masses.
 */
static int own_terms(const gap_hypothesis *h)
{
    return h->kind == GAP_EFFECT && h->basis ? mukca_effect_terms(h->effect.kind, h->effect.variant)
                                             : h->terms;
}

double gap_scan_correlation(gap_scan *scan, gap_model *m, int without, const gap_hypothesis *a,
                            const gap_hypothesis *b)
{
    enum { MOST = GAP_MAX_TERMS };
    double G[MOST * MOST], g[MOST], block[3][MOST * MOST], s[MOST];
    const int k = a->terms + b->terms, ka = own_terms(a), kb = own_terms(b);
    if (k > MOST || a->kind == GAP_DISTANCE || b->kind == GAP_DISTANCE) return NAN;
    projector p = lay_out(scan, m);
    leave_out(m, without);
    gap_model_pack(&m->pack[scan->rho], m, gap_rho[scan->rho]);
    aim(&p, m, &m->pack[scan->rho], scan->sigma);
    gap_hypothesis_columns(p.E, k, m, a);
    gap_hypothesis_columns(p.E + a->terms, k, m, b);
    project(G, g, &p, p.E, k, a);
    for (int i = 0; i < ka; i++)
        for (int j = 0; j < ka; j++) block[0][i * ka + j] = G[i * k + j];
    for (int i = 0; i < kb; i++)
        for (int j = 0; j < kb; j++) block[1][i * kb + j] = G[(a->terms + i) * k + a->terms + j];
    for (int i = 0; i < ka; i++) block[0][i * ka + i] *= 1 + 1e-9;
    for (int i = 0; i < kb; i++) block[1][i * kb + i] *= 1 + 1e-9;
    if (mukca_dense_cholesky(block[0], ka) || mukca_dense_cholesky(block[1], kb)) return NAN;
    for (int i = 0; i < ka; i++)
        for (int j = 0; j < kb; j++) block[2][i * kb + j] = G[i * k + a->terms + j];
    mukca_dense_forward(block[2], kb, block[0], ka);
    for (int i = 0; i < kb;
         i++) /* G as scratch: the transposed block, solved from the other side */
        for (int j = 0; j < ka; j++) G[i * ka + j] = block[2][j * kb + i];
    mukca_dense_forward(G, ka, block[1], kb);
    if (ka > kb) { /* the singular values of the transpose are the same */
        for (int i = 0; i < kb; i++)
            for (int j = 0; j < ka; j++) block[2][j * kb + i] = G[i * ka + j];
        memcpy(G, block[2], sizeof *G * (size_t)(ka * kb));
    }
    if (mukca_dense_svd(G, s, NULL, ka > kb ? ka : kb, ka > kb ? kb : ka)) return NAN;
    return fmin(s[0], 1);
}

mukca_status gap_scan_create(gap_scan *scan, gap_hypotheses *all, const gap_model *m,
                             mukca_error *error)
{
    const size_t rows = (size_t)(m->data->n_rows * m->dim), n = (size_t)m->capacity;
    const int harmonics = m->chain->n_joints * GAP_HARMONICS_KEPT;
    memset(scan, 0, sizeof *scan);
    scan->all = all;
    scan->harmonic = MUKCA_TAKE(&scan->pool, gap_hypothesis, harmonics);
    scan->harmonic_basis =
        MUKCA_TAKE(&scan->pool, float, (size_t)harmonics * 2 * (size_t)m->data->n_rows);
    scan->score = MUKCA_TAKE(&scan->pool, gap_score, all->count + harmonics);
    scan->memory =
        MUKCA_TAKE(&scan->pool, double,
                   (size_t)m->data->n_distances + (size_t)m->data->n_sockets + 8 + n + 2 * rows +
                       rows * (2 * n + 1) + 2 * rows * GAP_MAX_TERMS + n * 2 * GAP_MAX_TERMS);
    if (!scan->pool.failed) return MUKCA_OK;
    gap_scan_free(scan);
    return mukca_fail(error, MUKCA_MEMORY, "out of memory for the scan of %d candidates",
                      all->count);
}

void gap_scan_free(gap_scan *scan)
{
    mukca_pool_free(&scan->pool);
    memset(scan, 0, sizeof *scan);
}
