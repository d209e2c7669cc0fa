/* The projector for functions of one joint. */
#include "diagnose/joint_view.h"

#include <string.h>

#include "math/dense.h"

size_t mukca_joint_view_size(const mukca_regression *m)
{
    return (size_t)m->recording.data->n_rows *
           ((size_t)mukca_unknowns_capacity(&m->unknowns) + 3 + 4 * MUKCA_MAX_COLUMNS);
}

mukca_joint_view mukca_joint_view_aim(mukca_projector *p, int joint, double *memory)
{
    const mukca_regression *m = p->m;
    const mukca_recording *r = &m->recording;
    const int d = r->dim, n = p->n, n_joints = r->chain->n_joints, rows = r->n_samples;
    mukca_joint_view v = {.p = p, .joint = joint};
    v.Z = memory;
    v.u = v.Z + (size_t)rows * (size_t)n;
    v.diagonal = v.u + rows;
    v.off = v.diagonal + rows;
    v.F = v.off + rows;
    v.H = v.F + (size_t)rows * 2 * MUKCA_MAX_COLUMNS;
    for (int e = 0; e < r->n_groups; e++) {
        const mukca_group *group = &r->groups[e];
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
    const mukca_recording *r = &m->recording;
    const int d = r->dim, n = p->n, n_joints = r->chain->n_joints;
    memset(p->T, 0, sizeof *p->T * (size_t)(n * width));
    memset(g, 0, sizeof *g * (size_t)width);
    memset(mean, 0, sizeof *mean * (size_t)(r->n_groups * 3 * width));
    mukca_dense_xty(p->T, (mukca_columns){v->Z, n, n}, (mukca_columns){v->F, width, width},
                    r->n_samples);
    for (int e = 0; e < r->n_groups; e++) {
        const mukca_group *group = &r->groups[e];
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
    const mukca_recording *r = &m->recording;
    memset(G, 0, sizeof *G * (size_t)(k * k));
    mukca_dense_xty(G, (mukca_columns){v->H + at, k, width}, (mukca_columns){v->F + at, k, width},
                    r->n_samples);
    for (int e = 0; e < r->n_groups; e++) {
        if (r->groups[e].socket < 0) continue;
        for (int c = 0; c < 3; c++) {
            const double *x = mean + (3 * e + c) * width + at;
            for (int a = 0; a < k; a++)
                for (int b = 0; b < k; b++) G[a * k + b] -= p->weights[e] * x[a] * x[b];
        }
    }
    for (int i = 0; i < k * k; i++) G[i] *= p->precision;
    for (int q = 0; q < r->n_pairs; q++) {
        const mukca_socket_pair *pair = &r->pairs[q];
        double along[2 * MUKCA_MAX_COLUMNS] = {0};
        for (int c = 0; c < 3; c++)
            for (int a = 0; a < k; a++)
                along[a] += m->linear.direction[q][c] * (mean[(3 * pair->a + c) * width + at + a] -
                                                         mean[(3 * pair->b + c) * width + at + a]);
        for (int a = 0; a < k; a++)
            for (int b = 0; b < k; b++) G[a * k + b] += p->inverse[q] * along[a] * along[b];
    }
    double lost[MUKCA_MAX_COLUMNS * MUKCA_MAX_COLUMNS];
    memset(lost, 0, sizeof *lost * (size_t)(k * k));
    mukca_dense_syrk(lost, k, p->T + at, p->n, width);
    for (int i = 0; i < k * k; i++) G[i] -= lost[i];
}
