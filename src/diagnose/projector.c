/* What the present model leaves of a candidate's columns. */
#include "diagnose/projector.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "math/stats.h"

size_t mukca_projector_size(const mukca_regression *m)
{
    const size_t rows = (size_t)m->recording.data->n_rows * (size_t)m->recording.dim,
                 n = (size_t)mukca_unknowns_capacity(&m->unknowns);
    return (size_t)m->recording.data->n_distances + (size_t)m->recording.data->n_sockets + 8 + n +
           2 * rows + rows * (2 * n + 1) + 2 * rows * MUKCA_MAX_COLUMNS + n * 2 * MUKCA_MAX_COLUMNS;
}

mukca_projector mukca_projector_lay_out(mukca_regression *m, double *memory)
{
    mukca_projector p = {
        .m = m, .n = m->linear.n_columns, .rows = m->recording.n_samples * m->recording.dim};
    double *at = memory;
    p.inverse = at, at += m->recording.n_pairs + 1;
    p.weights = at, at += m->recording.n_groups + 1;
    p.z = at, at += p.n;
    p.mean_weight = at, at += m->recording.n_samples;
    p.u = at, at += p.rows;
    p.Q = at, at += (size_t)p.rows * (size_t)(p.n + 1);
    p.Zt = at, at += (size_t)p.rows * (size_t)p.n;
    p.E = at, at += (size_t)p.rows * MUKCA_MAX_COLUMNS;
    p.white = at, at += (size_t)p.rows * MUKCA_MAX_COLUMNS;
    p.T = at;
    return p;
}

/* AR(1) whitening of sample i of a group: its own and its predecessor's coefficient, and those with
 * which its successor takes it in (0 at the end). */
typedef struct {
    double own, before, next_own, next_before;
} whitening;

static whitening whitening_at(const mukca_projector *p, const mukca_group *group, int i)
{
    whitening w = {0};
    mukca_evidence_whitening(&w.own, &w.before, i, p->root, p->normal->rho);
    if (i + 1 < group->count)
        mukca_evidence_whitening(&w.next_own, &w.next_before, i + 1, p->root, p->normal->rho);
    return w;
}

/* Weights of the samples in the whitened mean of group g. */
static void weigh_group(mukca_projector *p, int g)
{
    const mukca_group *group = &p->m->recording.groups[g];
    double sum = 0;
    for (int i = 0; i < group->count; i++) {
        const whitening w = whitening_at(p, group, i);
        sum += (w.own - w.before) * (w.own - w.before);
    }
    p->weights[g] = sum;
    for (int i = 0; i < group->count; i++) {
        const whitening w = whitening_at(p, group, i);
        p->mean_weight[group->start + i] =
            (w.own * (w.own - w.before) - w.next_before * (w.next_own - w.next_before)) / sum;
    }
}

/* Q := W X and W y of the samples of a group: the transposed whitening of the whitened columns. */
static void fill_Q(mukca_projector *p, const mukca_group *group)
{
    const size_t step = (size_t)p->m->recording.dim * (size_t)(p->n + 1);
    for (int i = 0; i < group->count; i++) {
        const whitening w = whitening_at(p, group, i);
        const double *white = p->normal->white + (size_t)(group->start + i) * step;
        double *q = p->Q + (size_t)(group->start + i) * step;
        const double a = p->precision * w.own, b = p->precision * w.next_before;
        for (size_t k = 0; k < step; k++) q[k] = a * white[k];
        for (size_t k = 0; k < step && b > 0; k++) q[k] -= b * white[k + step];
    }
}

/* The distance rows' part of Q: each acts on the means of its two sockets. */
static void add_distances(mukca_projector *p)
{
    const mukca_recording *r = &p->m->recording;
    const int size = p->n + 1;
    for (int k = 0; k < r->n_pairs; k++)
        for (int side = 0; side < 2; side++) {
            const double *row = p->normal->distance + k * size;
            const mukca_group *group = &r->groups[side ? r->pairs[k].b : r->pairs[k].a];
            const double inverse = side ? -p->inverse[k] : p->inverse[k];
            for (int i = group->start; i < group->start + group->count; i++)
                for (int c = 0; c < 3; c++) {
                    const double w = inverse * p->m->linear.direction[k][c] * p->mean_weight[i];
                    double *q = p->Q + (size_t)(i * r->dim + c) * (size_t)size;
                    for (int e = 0; e < size; e++) q[e] += w * row[e];
                }
        }
}

/* Zt := (L^-1 D Q')', a block of rows at a time; u := W y - Zt z.  Columns with prior 0 drop out.
 */
static void fill_Zt(mukca_projector *p)
{
    enum { BLOCK = 32 };
    const double *prior = p->m->evidence.prior;
    const int n = p->n;
    const size_t size = (size_t)n + 1;
    double *B = p->T;
    for (int start = 0; start < p->rows; start += BLOCK) {
        const int count = p->rows - start < BLOCK ? p->rows - start : BLOCK;
        for (int r = 0; r < count; r++) {
            const double *q = p->Q + (size_t)(start + r) * size;
            for (int i = 0; i < n; i++) B[i * count + r] = q[i] * prior[i];
        }
        mukca_dense_forward(B, count, p->m->evidence.factor, n);
        for (int r = 0; r < count; r++) {
            double *x = p->Zt + (size_t)(start + r) * (size_t)n;
            double sum = p->Q[(size_t)(start + r + 1) * size - 1];
            for (int i = 0; i < n; i++) {
                x[i] = B[i * count + r];
                sum -= x[i] * p->z[i];
            }
            p->u[start + r] = sum;
        }
    }
}

double mukca_projector_block(double *G, double *g, const mukca_candidate *h, double residual,
                             int dof, double *information)
{
    const int k = h->terms;
    double A[MUKCA_MAX_COLUMNS * MUKCA_MAX_COLUMNS], x[MUKCA_MAX_COLUMNS], first[MUKCA_MAX_COLUMNS];
    double value[MUKCA_MAX_SIZES], scales[MUKCA_MAX_SIZES], weight[MUKCA_MAX_SIZES];
    const int n_scales = mukca_candidate_scales(scales, weight, h);
    const bool nonnegative =
        h->kind == MUKCA_CANDIDATE_EFFECT && mukca_effect_table[h->effect.kind]->nonnegative;
    double trace = 0;
    for (int i = 0; i < k; i++) {
        g[i] /= h->unit[i];
        for (int j = 0; j < k; j++) G[i * k + j] /= h->unit[i] * h->unit[j];
    }
    /* the terms behind the effect's own are what the masses may be off by */
    const int own = mukca_candidate_own_terms(h);
    for (int i = 0; i < own; i++) trace = fmax(trace, G[i * k + i]);
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
        value[s] = weight[s] - 0.5 * log_det - 0.5 * dof * log1p(-q / residual);
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
    return mukca_stats_log_sum_exp(value, n_scales);
}

/* G := E' W E of the samples, without the sockets' means. */
static void project_samples(double *G, mukca_projector *p, const double *E, int k)
{
    const mukca_recording *recording = &p->m->recording;
    const int d = recording->dim, step = d * k;
    double mean[MUKCA_MAX_COLUMNS];
    for (int g = 0; g < recording->n_groups; g++) {
        const mukca_group *group = &recording->groups[g];
        for (int i = 0; i < group->count; i++) {
            const double *e = E + (group->start + i) * step;
            double *white = p->white + (group->start + i) * step;
            const whitening w = whitening_at(p, group, i);
            for (int t = 0; t < step; t++)
                white[t] = w.own * e[t] - (i ? w.before * e[t - step] : 0);
        }
    }
    mukca_dense_syrk(G, k, p->white, p->rows, k);
    for (int i = 0; i < k * k; i++) G[i] *= p->precision;
    for (int g = 0; g < recording->n_groups; g++) {
        const mukca_group *group = &recording->groups[g];
        const double w = p->precision * p->weights[g];
        for (int c = 0; c < 3 && group->socket >= 0; c++) {
            memset(mean, 0, sizeof mean);
            for (int i = group->start; i < group->start + group->count; i++)
                for (int t = 0; t < k; t++) mean[t] += p->mean_weight[i] * E[(i * d + c) * k + t];
            for (int a = 0; a < k; a++)
                for (int b = 0; b < k; b++) G[a * k + b] -= w * mean[a] * mean[b];
        }
    }
}

/* along[k]: what the columns do to the distance of a pair of sockets. */
static void pair_columns(double *along, const mukca_projector *p, const double *E, int k, int pair)
{
    const mukca_recording *r = &p->m->recording;
    const double *direction = p->m->linear.direction[pair];
    memset(along, 0, sizeof *along * (size_t)k);
    for (int side = 0; side < 2; side++) {
        const mukca_group *group = &r->groups[side ? r->pairs[pair].b : r->pairs[pair].a];
        for (int i = group->start; i < group->start + group->count; i++)
            for (int c = 0; c < 3; c++) {
                const double w = (side ? -1 : 1) * p->mean_weight[i] * direction[c];
                for (int t = 0; t < k; t++) along[t] += w * E[(i * r->dim + c) * k + t];
            }
    }
}

void mukca_projector_project(double *G, double *g, mukca_projector *p, const double *E, int k,
                             const mukca_candidate *h)
{
    const mukca_regression *m = p->m;
    const int n = p->n;
    double along[MUKCA_MAX_COLUMNS];
    memset(G, 0, sizeof *G * (size_t)(k * k));
    memset(g, 0, sizeof *g * (size_t)k);
    memset(p->T, 0, sizeof *p->T * (size_t)(n * k));
    project_samples(G, p, E, k);
    for (int r = 0; r < m->recording.n_pairs; r++) {
        pair_columns(along, p, E, k, r);
        if (mukca_candidate_changes_pair(h, &m->recording, r)) { /* on the distance row alone */
            const double *row = p->normal->distance + r * (n + 1);
            along[0] = -1;
            g[0] -= p->inverse[r] * row[n];
            for (int i = 0; i < n; i++) p->T[i] -= p->inverse[r] * row[i] * m->evidence.prior[i];
        }
        for (int a = 0; a < k; a++)
            for (int b = 0; b < k; b++) G[a * k + b] += p->inverse[r] * along[a] * along[b];
    }
    if (h->kind == MUKCA_CANDIDATE_DISTANCE) {
        mukca_dense_forward(p->T, 1, m->evidence.factor, n);
        for (int i = 0; i < n; i++) g[0] -= p->T[i] * p->z[i];
    } else {
        mukca_dense_xty(p->T, (mukca_columns){p->Zt, n, n}, (mukca_columns){E, k, k}, p->rows);
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
double mukca_projector_fault(mukca_projector *p, const mukca_candidate *h, double *information)
{
    const mukca_recording *r = &p->m->recording;
    const mukca_group *group = &r->groups[h->fault.group];
    const int d = r->dim, n = p->n;
    double T[3][512], G[9], g[3] = {0, 0, 0}, square = 0, mean = 0, last = 0;
    if (n > 512) return -HUGE_VAL;
    memset(T, 0, sizeof T);
    for (int i = 0; i < group->count; i++) {
        const double share = mukca_candidate_fault_share(h, r, r->order[group->start + i]);
        const whitening w = whitening_at(p, group, i);
        const double white = w.own * share - w.before * last;
        last = share;
        square += white * white;
        if (share == 0) continue;
        if (group->socket >= 0) mean += p->mean_weight[group->start + i] * share;
        for (int c = 0; c < 3; c++) {
            const int at = (group->start + i) * d + c;
            const double *z = p->Zt + (size_t)at * (size_t)n;
            for (int k = 0; k < n; k++) T[c][k] -= share * z[k];
            g[c] -= share * p->u[at];
        }
    }
    /* mean is 0 in a pose log, which has no free mean */
    const double own_part = p->precision * (square - p->weights[h->fault.group] * mean * mean);
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            double sum = a == b ? own_part : 0;
            for (int k = 0; k < n; k++) sum -= T[a][k] * T[b][k];
            G[3 * a + b] = sum;
        }
    for (int q = 0; q < r->n_pairs; q++) {
        const double *direction = p->m->linear.direction[q], w = p->inverse[q] * mean * mean;
        if (r->pairs[q].a != h->fault.group && r->pairs[q].b != h->fault.group) continue;
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++) G[3 * a + b] += w * direction[a] * direction[b];
    }
    return mukca_projector_block(G, g, h, p->residual, p->normal->dof, information);
}

double mukca_projector_field(mukca_projector *p, const mukca_candidate *h, double *information)
{
    double G[MUKCA_MAX_COLUMNS * MUKCA_MAX_COLUMNS], g[MUKCA_MAX_COLUMNS];
    mukca_linearisation_columns(p->E, h->terms, &p->m->linear, &p->m->recording, h);
    mukca_projector_project(G, g, p, p->E, h->terms, h);
    return mukca_projector_block(G, g, h, p->residual, p->normal->dof, information);
}

void mukca_projector_aim(mukca_projector *p, const mukca_normal_equations *normal, double sigma)
{
    mukca_regression *m = p->m;
    const mukca_recording *r = &m->recording;
    const int n = p->n;
    p->normal = normal;
    p->precision = 1 / (sigma * sigma);
    p->root = sqrt(1 - normal->rho * normal->rho);
    mukca_evidence_evaluate(&m->evidence, normal, sigma, NULL);
    memcpy(p->z, m->evidence.work, sizeof *p->z * (size_t)n);
    p->residual = p->precision * normal->gram[(size_t)(n + 1) * (size_t)(n + 1) - 1];
    const double known = normal->distance_sigma * normal->distance_sigma;
    for (int k = 0; k < normal->n_pairs; k++)
        p->inverse[k] = 1 / (known + sigma * sigma * normal->variance[k]);
    for (int g = 0; g < r->n_groups; g++) {
        weigh_group(p, g);
        fill_Q(p, &r->groups[g]);
    }
    add_distances(p);
    fill_Zt(p);
    for (int k = 0; k < r->n_pairs; k++) {
        const double y = normal->distance[k * (n + 1) + n];
        p->residual += p->inverse[k] * y * y;
    }
    for (int k = 0; k < n; k++) p->residual -= p->z[k] * p->z[k];
    p->residual = fmax(p->residual, 1e-9);
}
