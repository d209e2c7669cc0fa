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

static void prepare(mukca_projector *p)
{
    const mukca_regression *m = p->m;
    const int d = m->recording.dim, n = p->n, size = n + 1;
    const double rho = p->normal->rho, sigma2 = 1 / p->precision;
    const double *L = m->evidence.factor;
    const double sd2 = m->recording.options.distance_sigma * m->recording.options.distance_sigma;
    for (int k = 0; k < m->recording.n_pairs; k++)
        p->inverse[k] = 1 / (sd2 + sigma2 * p->normal->variance[k]);
    for (int g = 0; g < m->recording.n_groups; g++) {
        const mukca_group *group = &m->recording.groups[g];
        double sum = 0;
        for (int i = 0; i < group->count; i++) {
            double own, before;
            mukca_evidence_whitening(&own, &before, i, p->root, p->normal->rho);
            sum += (own - before) * (own - before);
        }
        p->weights[g] = sum;
        for (int i = 0; i < group->count; i++) {
            double own, before, next_own, next_before, w;
            mukca_evidence_whitening(&own, &before, i, p->root, p->normal->rho);
            mukca_evidence_whitening(&next_own, &next_before, i + 1, p->root, p->normal->rho);
            w = own * (own - before);
            if (i + 1 < group->count) w -= next_before * (next_own - next_before);
            p->mean_weight[group->start + i] = w / sum;
            for (int c = 0; c < d; c++) {
                const size_t at = (size_t)((group->start + i) * d + c) * (size_t)size;
                const double *white = p->normal->white + at;
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
    for (int k = 0; k < m->recording.n_pairs; k++) {
        const mukca_socket_pair *pair = &m->recording.pairs[k];
        const double *row = p->normal->distance + k * size;
        for (int side = 0; side < 2; side++) {
            const mukca_group *group = &m->recording.groups[side ? pair->b : pair->a];
            for (int i = group->start; i < group->start + group->count; i++)
                for (int c = 0; c < 3; c++) {
                    const double w = (side ? -1 : 1) * p->inverse[k] * m->linear.direction[k][c] *
                                     p->mean_weight[i];
                    double *q = p->Q + (size_t)(i * d + c) * (size_t)size;
                    for (int e = 0; e < size; e++) q[e] += w * row[e];
                }
        }
    }
    /* Zt := (L^-1 D Q')', a block of rows at a time; u := W y - Zt z.  Columns with prior 0 drop
     * out. */
    enum { BLOCK = 32 };
    double *B = p->T;
    for (int start = 0; start < p->rows; start += BLOCK) {
        const int count = p->rows - start < BLOCK ? p->rows - start : BLOCK;
        for (int r = 0; r < count; r++) {
            const double *q = p->Q + (size_t)(start + r) * (size_t)size;
            for (int i = 0; i < n; i++) B[i * count + r] = q[i] * m->evidence.prior[i];
        }
        mukca_dense_forward(B, count, L, n);
        for (int r = 0; r < count; r++) {
            double *x = p->Zt + (size_t)(start + r) * (size_t)n;
            double sum = p->Q[(size_t)(start + r) * (size_t)size + (size_t)n];
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
    double value[8];
    const double *scales;
    const int n_scales = mukca_candidate_scales(&scales, h);
    const bool nonnegative =
        h->kind == MUKCA_CANDIDATE_EFFECT && mukca_effect_table[h->effect.kind].nonnegative;
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

void mukca_projector_project(double *G, double *g, mukca_projector *p, const double *E, int k,
                             const mukca_candidate *h)
{
    const mukca_regression *m = p->m;
    const int d = m->recording.dim, n = p->n;
    double along[MUKCA_MAX_COLUMNS];
    memset(G, 0, sizeof *G * (size_t)(k * k));
    memset(g, 0, sizeof *g * (size_t)k);
    memset(p->T, 0, sizeof *p->T * (size_t)(n * k));
    for (int e = 0; e < m->recording.n_groups; e++) {
        const mukca_group *group = &m->recording.groups[e];
        for (int i = 0; i < group->count; i++) {
            double own, before;
            mukca_evidence_whitening(&own, &before, i, p->root, p->normal->rho);
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
    double mean[MUKCA_MAX_COLUMNS];
    for (int e = 0; e < m->recording.n_groups; e++) {
        const mukca_group *group = &m->recording.groups[e];
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
    for (int r = 0; r < m->recording.n_pairs; r++) {
        const mukca_socket_pair *pair = &m->recording.pairs[r];
        memset(along, 0, sizeof along);
        for (int side = 0; side < 2; side++) {
            const mukca_group *group = &m->recording.groups[side ? pair->b : pair->a];
            for (int i = group->start; i < group->start + group->count; i++)
                for (int c = 0; c < 3; c++) {
                    const double w =
                        (side ? -1 : 1) * p->mean_weight[i] * m->linear.direction[r][c];
                    for (int t = 0; t < k; t++) along[t] += w * E[(i * d + c) * k + t];
                }
        }
        if (mukca_candidate_changes_pair(
                h, &m->recording,
                r)) { /* acts on the distance rows alone: what prepare() left out */
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
double mukca_projector_fault(mukca_projector *p, const mukca_candidate *h, double *information)
{
    const mukca_regression *m = p->m;
    const mukca_group *group = &m->recording.groups[h->fault.group];
    const int d = m->recording.dim, n = p->n;
    double T[3][512], G[9], g[3] = {0, 0, 0}, square = 0, mean = 0, last = 0;
    if (n > 512) return -HUGE_VAL;
    memset(T, 0, sizeof T);
    for (int i = 0; i < group->count; i++) {
        const int row = m->recording.order[group->start + i];
        const double share = mukca_candidate_fault_share(h, &m->recording, row);
        double own, before;
        mukca_evidence_whitening(&own, &before, i, p->root, p->normal->rho);
        const double white = own * share - before * last;
        last = share;
        square += white * white;
        if (share == 0) continue;
        if (group->socket >= 0) mean += p->mean_weight[group->start + i] * share;
        for (int c = 0; c < 3; c++) {
            const size_t r = (size_t)(group->start + i) * (size_t)d + (size_t)c;
            const double *z = p->Zt + r * (size_t)n;
            for (int k = 0; k < n; k++) T[c][k] -= share * z[k];
            g[c] -= share * p->u[r];
        }
    }
    const double own_part =
        p->precision *
        (square - (group->socket >= 0 ? p->weights[h->fault.group] * mean * mean : 0));
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            double sum = a == b ? own_part : 0;
            for (int k = 0; k < n; k++) sum -= T[a][k] * T[b][k];
            G[3 * a + b] = sum;
        }
    for (int r = 0; r < m->recording.n_pairs; r++) {
        const mukca_socket_pair *pair = &m->recording.pairs[r];
        if (pair->a != h->fault.group && pair->b != h->fault.group) continue;
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++)
                G[3 * a + b] += p->inverse[r] * mean * mean * m->linear.direction[r][a] *
                                m->linear.direction[r][b];
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
    const int n = p->n;
    p->normal = normal;
    p->precision = 1 / (sigma * sigma);
    p->root = sqrt(1 - normal->rho * normal->rho);
    mukca_evidence_evaluate(&m->evidence, normal, sigma, NULL);
    memcpy(p->z, m->evidence.work, sizeof *p->z * (size_t)n);
    p->residual = p->precision * normal->gram[(size_t)(n + 1) * (size_t)(n + 1) - 1];
    prepare(p);
    for (int k = 0; k < m->recording.n_pairs; k++) {
        const double y = normal->distance[k * (n + 1) + n];
        p->residual += p->inverse[k] * y * y;
    }
    for (int k = 0; k < n; k++) p->residual -= p->z[k] * p->z[k];
    p->residual = fmax(p->residual, 1e-9);
}

size_t mukca_joint_view_size(const mukca_regression *m)
{
    return (size_t)m->recording.data->n_rows *
           ((size_t)mukca_unknowns_capacity(&m->unknowns) + 3 + 4 * MUKCA_MAX_COLUMNS);
}

mukca_joint_view mukca_joint_view_aim(mukca_projector *p, int joint, double *memory)
{
    const mukca_regression *m = p->m;
    const int d = m->recording.dim, n = p->n, n_joints = m->recording.chain->n_joints,
              rows = m->recording.n_samples;
    mukca_joint_view v = {.p = p, .joint = joint};
    v.Z = memory;
    v.u = v.Z + (size_t)rows * (size_t)n;
    v.diagonal = v.u + rows;
    v.off = v.diagonal + rows;
    v.F = v.off + rows;
    v.H = v.F + (size_t)rows * 2 * MUKCA_MAX_COLUMNS;
    for (int e = 0; e < m->recording.n_groups; e++) {
        const mukca_group *group = &m->recording.groups[e];
        for (int k = 0; k < group->count; k++) {
            const int i = group->start + k;
            const double *lever = m->linear.lever + (size_t)(i * n_joints + joint) * (size_t)d;
            double *z = v.Z + (size_t)i * (size_t)n;
            double own, before, next_own, next_before, square = 0, product = 0;
            memset(z, 0, sizeof *z * (size_t)n);
            v.u[i] = 0;
            for (int c = 0; c < d; c++) {
                const double *from = p->Zt + (size_t)(i * d + c) * (size_t)n;
                for (int t = 0; t < n; t++) z[t] += lever[c] * from[t];
                v.u[i] += lever[c] * p->u[i * d + c];
                square += lever[c] * lever[c];
                if (k) product += lever[c] * lever[c - n_joints * d];
            }
            mukca_evidence_whitening(&own, &before, k, p->root, p->normal->rho);
            mukca_evidence_whitening(&next_own, &next_before, k + 1, p->root, p->normal->rho);
            v.diagonal[i] =
                square * (own * own + (k + 1 < group->count ? next_before * next_before : 0));
            v.off[i] = -2 * own * before * product;
        }
    }
    return v;
}

void mukca_joint_view_project(double *g, double *mean, const mukca_joint_view *v, int width)
{
    const mukca_projector *p = v->p;
    const mukca_regression *m = p->m;
    const int d = m->recording.dim, n = p->n, n_joints = m->recording.chain->n_joints;
    memset(p->T, 0, sizeof *p->T * (size_t)(n * width));
    memset(g, 0, sizeof *g * (size_t)width);
    memset(mean, 0, sizeof *mean * (size_t)(m->recording.n_groups * 3 * width));
    mukca_dense_xty(p->T, width, v->Z, n, n, v->F, width, width, m->recording.n_samples);
    for (int e = 0; e < m->recording.n_groups; e++) {
        const mukca_group *group = &m->recording.groups[e];
        for (int i = group->start; i < group->start + group->count; i++) {
            const double *lever = m->linear.lever + (size_t)(i * n_joints + v->joint) * (size_t)d;
            const double *f = v->F + (size_t)i * (size_t)width;
            double *h = v->H + (size_t)i * (size_t)width;
            for (int t = 0; t < width; t++) {
                g[t] += v->u[i] * f[t];
                h[t] = v->diagonal[i] * f[t];
            }
            if (v->off[i] != 0)
                for (int t = 0; t < width; t++) h[t] += v->off[i] * f[t - width];
            for (int c = 0; c < 3 && group->socket >= 0; c++) {
                const double w = p->mean_weight[i] * lever[c];
                double *to = mean + (3 * e + c) * width;
                for (int t = 0; t < width; t++) to[t] += w * f[t];
            }
        }
    }
}

void mukca_joint_view_gram(double *G, const mukca_joint_view *v, const double *mean, int width,
                           int at, int k)
{
    const mukca_projector *p = v->p;
    const mukca_regression *m = p->m;
    memset(G, 0, sizeof *G * (size_t)(k * k));
    mukca_dense_xty(G, k, v->H + at, k, width, v->F + at, k, width, m->recording.n_samples);
    for (int e = 0; e < m->recording.n_groups; e++) {
        if (m->recording.groups[e].socket < 0) continue;
        for (int c = 0; c < 3; c++) {
            const double *x = mean + (3 * e + c) * width + at;
            for (int a = 0; a < k; a++)
                for (int b = 0; b < k; b++) G[a * k + b] -= p->weights[e] * x[a] * x[b];
        }
    }
    for (int i = 0; i < k * k; i++) G[i] *= p->precision;
    for (int r = 0; r < m->recording.n_pairs; r++) {
        const mukca_socket_pair *pair = &m->recording.pairs[r];
        double along[2 * MUKCA_MAX_COLUMNS] = {0};
        for (int c = 0; c < 3; c++)
            for (int a = 0; a < k; a++)
                along[a] += m->linear.direction[r][c] * (mean[(3 * pair->a + c) * width + at + a] -
                                                         mean[(3 * pair->b + c) * width + at + a]);
        for (int a = 0; a < k; a++)
            for (int b = 0; b < k; b++) G[a * k + b] += p->inverse[r] * along[a] * along[b];
    }
    double lost[MUKCA_MAX_COLUMNS * MUKCA_MAX_COLUMNS];
    memset(lost, 0, sizeof *lost * (size_t)(k * k));
    mukca_dense_syrk(lost, k, p->T + at, p->n, width);
    for (int i = 0; i < k * k; i++) G[i] -= lost[i];
}
