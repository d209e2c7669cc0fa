/* Scores of faults of one socket or sample. */
#include "diagnose/scan.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "math/four.h"

/* Running sums over the samples of one group. */
typedef struct {
    mukca_scan *scan;
    int group, ld;
    double *Z; /* [n][ld] sums of L^-1 D X' of each row, by sample and coordinate, from the first
                  sample on */
    double *u; /* [count][dim] sums of the residual */
    double *x, *turned;    /* [n_samples][dim] a column of the model, of which Z is made */
    double *T;             /* [3][n] of a fault */
    double *share, *white; /* [n_samples] displacement by it; whitened */
    mukca_samples samples; /* the group alone, one coordinate */
    mukca_whitening whitening, plain; /* of the group; without correlation of coordinates */
} fault_sums;

/* Z: L^-1 D (A'X)', with the effect of the group's mean on the distances; sums of the residual u.
 */
static void fill(fault_sums *f, const double *u)
{
    mukca_scan *s = f->scan;
    const mukca_recording *r = &s->m->recording;
    const mukca_linearisation *linear = &s->m->linear;
    const mukca_group *group = &r->groups[f->group];
    const int n = s->n, d = r->dim, count = group->count, ld = f->ld;
    double *x = f->x, *turned = f->turned;
    for (int t = 0; t < n; t++) {
        double *Z = f->Z + (size_t)t * (size_t)ld;
        memset(Z, 0, sizeof *Z * (size_t)ld);
        for (int i = 0; i < count * d; i++) {
            const size_t row = (size_t)group->start * (size_t)d + (size_t)i;
            x[row] = s->precision * s->white[row * (size_t)linear->stride + (size_t)t];
        }
        for (int p = 0; p < r->n_pairs; p++) {
            const double sign = (r->pairs[p].a == f->group) - (r->pairs[p].b == f->group),
                         *pair = s->white + (r->n_samples * d + p) * (long)linear->stride,
                         by = sign * s->precision * s->link[p] * pair[t];
            double v[6] = {0};
            if (!(by != 0)) continue;
            for (int c = 0; c < 3; c++) v[c] = by * linear->direction[p][c];
            mukca_whitening_solve(v, &f->whitening, 0, d);
            for (int i = group->start * d; i < (group->start + count) * d; i++)
                for (int c = 0; c < d; c++) x[i] += f->whitening.one[i * d + c] * v[c];
        }
        mukca_samples block = f->samples;
        block.dim = d;
        mukca_whitening_transpose(turned, x, 1, 1, &f->whitening, &block);
        for (int i = 0; i < count * d; i++) Z[i] = s->prior[t] * turned[group->start * d + i];
    }
    for (int i = 0; i < count * d; i++)
        f->u[i] = u[group->start * d + i] + (i < d ? 0 : f->u[i - d]);
    mukca_dense_forward8(f->Z, ld, ld, s->m->evidence.posterior.factor, n);
    for (int t = 0; t < n; t++)
        for (int i = d; i < count * d; i++)
            f->Z[(size_t)t * (size_t)ld + (size_t)i] +=
                f->Z[(size_t)t * (size_t)ld + (size_t)(i - d)];
}

/* Samples [from, to) of the group that a fault displaces. */
static void find_samples(int *from, int *to, const mukca_recording *r, const mukca_candidate *h)
{
    const mukca_group *group = &r->groups[h->fault.group];
    const int *row = r->order + group->start; /* ascending */
    for (*from = 0; *from < group->count && row[*from] < h->fault.first;) ++*from;
    for (*to = *from; *to < group->count && row[*to] <= h->fault.last;) ++*to;
}

/* G[3][3] += by L'^-1 L^-1, of the position. */
static void add_inverse(double G[9], const double *L, int d, double by)
{
    double x[18] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    mukca_dense_forward(x, 3, L, d);
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            for (int c = 0; c < d; c++) G[3 * a + b] += by * x[3 * c + a] * x[3 * c + b];
}

/* G[3][3] := products of a fault's columns, white[n_samples] if coordinates do not correlate.  What
 * the socket's mean absorbs is approximate if they do. */
static void multiply(double G[9], const fault_sums *f, const double *white)
{
    const mukca_group *group = &f->scan->m->recording.groups[f->group];
    const int d = f->scan->m->recording.dim, *next = f->samples.next;
    const double least = 1e-3; /* share of a posture that is negligible */
    double all = 0, rest = 0;
    for (int i = group->start; i < group->start + group->count; i++) all += white[i] * white[i];
    memset(G, 0, sizeof(double[9]));
    for (int i = group->start; i < group->start + group->count && f->whitening.shape.mean; i++) {
        const int m = f->whitening.family.shared > 0 ? f->samples.readings[i] : 1;
        const size_t at = (size_t)i * (size_t)(d * d);
        double mean = 0, square = 0;
        for (int k = i; k >= 0 && m; k = m > 1 ? next[k] : -1) mean += white[k] / m;
        for (int k = i; k >= 0 && m > 1; k = next[k])
            square += (white[k] - mean) * (white[k] - mean);
        const double part[] = {m * mean * mean, square};
        const double *L[] = {f->whitening.shape.mean, f->whitening.shape.deviation};
        for (int k = 0; k < 2; k++)
            if (part[k] > least * all) add_inverse(G, L[k] + at, d, part[k]), rest += part[k];
    }
    for (int c = 0; c < 3; c++) G[4 * c] += all - rest;
}

static void score(double *value, double *information, fault_sums *f, const mukca_candidate *h)
{
    mukca_scan *s = f->scan;
    const mukca_recording *r = &s->m->recording;
    const mukca_group *group = &r->groups[f->group];
    const int n = s->n, d = r->dim;
    double *T = f->T, *share = f->share, *white = f->white, mean = 0, G[9], g[3];
    int from, to;
    find_samples(&from, &to, r, h);
    for (int i = 0; i < group->count; i++)
        share[group->start + i] = mukca_candidate_fault_share(h, r, r->order[group->start + i]);
    mukca_whitening_apply(
        &(mukca_whitened){.n = 1, .ld = 1, .x = share, .white = white, .mean = &mean}, &f->plain,
        &f->samples);
    multiply(G, f, white);
    memset(T, 0, sizeof *T * (size_t)(3 * n));
    memset(g, 0, sizeof g);
    const bool varies = h->fault.shape != MUKCA_FAULT_STEADY;
    for (int i = varies ? from : to - 1; i < to; i++) {
        const int start = varies ? i : from;
        const double w = share[group->start + i];
        for (int c = 0; c < 3; c++) {
            const int last = i * d + c, before = (start - 1) * d + c;
            g[c] -= w * (f->u[last] - (start ? f->u[before] : 0));
            for (int t = 0; t < n; t++) {
                const double *Z = f->Z + (size_t)t * (size_t)f->ld;
                T[c * n + t] -= w * (Z[last] - (start ? Z[before] : 0));
            }
        }
    }
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            G[3 * a + b] = s->precision * G[3 * a + b] - dot4(T + a * n, T + b * n, n);
    for (int p = 0; p < r->n_pairs; p++) {
        const double *direction = s->m->linear.direction[p],
                     w = s->precision * pow(s->link[p] * mean, 2);
        if (r->pairs[p].a != f->group && r->pairs[p].b != f->group) continue;
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++) G[3 * a + b] += w * direction[a] * direction[b];
    }
    const mukca_mixture prior = mukca_candidate_mixture(h);
    *information = G[0];
    *value = mukca_mixture_evidence(NULL, G, g, 3, &prior, s->residual, s->dof, s->scratch);
}

bool mukca_scan_faults(mukca_scan *s, mukca_pool *pool, const double *u)
{
    const mukca_recording *r = &s->m->recording;
    const int d = r->dim, rows = r->n_samples * d;
    mukca_samples scalars = r->samples;
    mukca_whitening plain;
    mukca_block block;
    fault_sums f = {.scan = s,
                    .Z = MUKCA_TAKE(pool, double, (size_t)(rows + 8) * (size_t)(s->n + 1)),
                    .u = MUKCA_TAKE(pool, double, rows),
                    .x = MUKCA_TAKE(pool, double, rows),
                    .turned = MUKCA_TAKE(pool, double, rows),
                    .T = MUKCA_TAKE(pool, double, 3 * (s->n + 1)),
                    .share = MUKCA_TAKE(pool, double, r->n_samples),
                    .white = MUKCA_TAKE(pool, double, r->n_samples),
                    .samples = {.n_samples = r->n_samples,
                                .n_blocks = 1,
                                .dim = 1,
                                .block = &block,
                                .next = r->samples.next,
                                .readings = r->samples.readings}};
    mukca_whitening_create(&plain, pool, r->data->n_rows, r->data->n_sockets + 2, 1);
    if (pool->failed) return false;
    scalars.dim = 1;
    mukca_whitening_set(&plain, &scalars, s->normal->whitening.family,
                        (mukca_noise_shape){NULL, NULL}, NULL);
    for (int g = 0; g < r->n_groups; g++) {
        const mukca_group *group = &r->groups[g];
        block = (mukca_block){group->start, group->count, group->socket >= 0};
        f.group = g;
        f.ld = (group->count * d + 7) & ~7;
        f.whitening = s->normal->whitening;
        f.plain = plain;
        f.whitening.total += g * d * d;
        f.plain.total += g;
        bool filled = false;
        for (int k = 0; k < s->all->count; k++) {
            const mukca_candidate *h = &s->all->list[k];
            if (!mukca_candidate_is_fault(h) || h->fault.group != g) continue;
            s->value[k] = -HUGE_VAL, s->information[k] = 0;
            if (!r->keep[h->fault.first] || !group->count) continue;
            if (!filled) fill(&f, u);
            filled = true;
            score(&s->value[k], &s->information[k], &f, h);
        }
    }
    return true;
}
