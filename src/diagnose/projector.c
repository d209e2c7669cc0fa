/* What the present model leaves of a candidate's columns. */
#include "diagnose/projector.h"

#include <math.h>
#include <string.h>

#include "diagnose/ripple.h"
#include "math/dense.h"
#include "math/stats.h"

bool mukca_projector_create(mukca_projector *p, mukca_pool *pool, mukca_regression *m)
{
    const size_t rows = (size_t)m->recording.data->n_rows * (size_t)m->recording.dim,
                 n = (size_t)mukca_unknowns_capacity(&m->unknowns);
    *p = (mukca_projector){.m = m,
                           .inverse = MUKCA_TAKE(pool, double, m->recording.data->n_distances + 1),
                           .z = MUKCA_TAKE(pool, double, n),
                           .T = MUKCA_TAKE(pool, double, (n + 1) * MUKCA_BATCH),
                           .u = MUKCA_TAKE(pool, double, rows),
                           .Zt = MUKCA_TAKE(pool, double, rows *n)};
    return mukca_products_create(&p->own, pool, m, MUKCA_MAX_COLUMNS, MUKCA_MAX_COLUMNS) &&
           mukca_products_scratch(&p->scratch, pool, m);
}

/* What the distances add to a row of W X and W y; column k of B gets the former times D. */
static void add_distances(double *B, mukca_projector *p, int group, int i, int c)
{
    const mukca_recording *r = &p->m->recording;
    const double *prior = p->m->evidence.prior;
    for (int k = 0; k < r->n_pairs; k++) {
        const double direction = p->m->linear.direction[k][c],
                     sign = r->pairs[k].a == group   ? 1
                            : r->pairs[k].b == group ? -1
                                                     : 0,
                     w = sign * p->inverse[k] * direction * p->normal->mean_weight[i];
        const double *distance = p->normal->distance + k * (p->n + 1);
        for (int t = 0; t < p->n && sign != 0; t++)
            B[t * MUKCA_BATCH] += w * distance[t] * prior[t];
        if (sign != 0) p->u[i * r->dim + c] += w * distance[p->n];
    }
}

/* Zt := (L^-1 D (WX)')', a block of samples at a time; u := W y - Zt z. */
static void fill_rows(mukca_projector *p, int group, int start, int count)
{
    const mukca_recording *r = &p->m->recording;
    const double *prior = p->m->evidence.prior;
    const int n = p->n, d = r->dim, *at = p->m->linear.at;
    const size_t stride = (size_t)p->m->linear.stride;
    double *B = p->T;
    for (int k = 0; k < count * d; k++) {
        const double *w = p->normal->weighted + (size_t)(start * d + k) * stride;
        for (int t = 0; t < n; t++) B[t * MUKCA_BATCH + k] = p->precision * w[at[t]] * prior[t];
        p->u[start * d + k] = p->precision * w[at[n]];
        if (k % d < 3 && r->groups[group].socket >= 0)
            add_distances(B + k, p, group, start + k / d, k % d);
    }
    for (int t = 0; t < n; t++)
        for (int k = count * d; k < MUKCA_BATCH; k++) B[t * MUKCA_BATCH + k] = 0;
    mukca_dense_forward(B, MUKCA_BATCH, p->m->evidence.factor, n);
    for (int k = 0; k < count * d; k++) {
        double *x = p->Zt + (size_t)(start * d + k) * (size_t)n, sum = 0;
        for (int t = 0; t < n; t++) {
            x[t] = B[t * MUKCA_BATCH + k];
            sum += x[t] * p->z[t];
        }
        p->u[start * d + k] -= sum;
    }
}

void mukca_projector_rows(mukca_projector *p)
{
    const mukca_recording *r = &p->m->recording;
    const int most = MUKCA_BATCH / r->dim;
    for (int g = 0; g < r->n_groups && !p->have_rows; g++)
        for (int k = 0; k < r->groups[g].count; k += most)
            fill_rows(p, g, r->groups[g].start + k,
                      r->groups[g].count - k < most ? r->groups[g].count - k : most);
    p->have_rows = true;
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

/* Columns of a few items side by side: their right sides in T and g. */
typedef struct {
    int n, width;
    double g[MUKCA_BATCH];
    struct {
        const mukca_scored *item;
        int first, count, at; /* columns of the item, and where they are */
    } entry[MUKCA_BATCH];
} batch;

/* T := D X'W E and g := E'W y of an entry. */
static void fill(batch *b, const mukca_projector *p, int e)
{
    const mukca_products *x = b->entry[e].item->products;
    const int n = p->n, first = b->entry[e].first, count = b->entry[e].count,
              *held = p->m->linear.at;
    const double *prior = p->m->evidence.prior;
    for (int t = 0; t <= n; t++) {
        const double *cross = x->cross + (size_t)held[t] * (size_t)x->columns + first;
        double *out = t < n ? p->T + t * MUKCA_BATCH + b->entry[e].at : b->g + b->entry[e].at;
        for (int k = 0; k < count; k++) out[k] = p->precision * cross[k];
        for (int q = 0; q < p->normal->n_pairs; q++) {
            const double w = p->inverse[q] * p->normal->distance[q * (n + 1) + t];
            const double *along = x->along + q * x->columns + first;
            for (int k = 0; k < count && w != 0; k++) out[k] += w * along[k];
        }
        for (int k = 0; k < count && t < n; k++) out[k] *= prior[t];
    }
}

/* Projected G[k][k] and g[k] of one block of an entry, `column` columns on. */
static void take_block(double *G, double *g, const batch *b, const mukca_projector *p, int e,
                       int column)
{
    const mukca_products *x = b->entry[e].item->products;
    const int k = x->block, first = b->entry[e].first + column, at = b->entry[e].at + column;
    double lost[MUKCA_MAX_COLUMNS * MUKCA_MAX_COLUMNS];
    memset(lost, 0, sizeof *lost * (size_t)(k * k));
    for (int a = 0; a < k; a++) g[a] = b->g[at + a];
    for (int t = 0; t < p->n; t++)
        for (int a = 0; a < k; a++) g[a] -= p->T[t * MUKCA_BATCH + at + a] * p->z[t];
    mukca_dense_syrk(lost, k, p->T + at, p->n, MUKCA_BATCH);
    for (int a = 0; a < k; a++)
        for (int c = 0; c < k; c++) {
            double sum = p->precision * x->gram[(first + a) * k + c] - lost[a * k + c];
            for (int q = 0; q < p->normal->n_pairs; q++)
                sum += p->inverse[q] * x->along[q * x->columns + first + a] *
                       x->along[q * x->columns + first + c];
            G[a * k + c] = sum;
        }
}

/* Solve for the whole batch. */
static void solve(const batch *b, mukca_projector *p)
{
    const int width = (b->width + 7) & ~7; /* whole registers */
    for (int t = 0; t < p->n; t++)
        for (int k = b->width; k < width; k++) p->T[t * MUKCA_BATCH + k] = 0;
    mukca_dense_forward8(p->T, width, MUKCA_BATCH, p->m->evidence.factor, p->n);
}

static void finish(batch *b, mukca_projector *p)
{
    double G[MUKCA_MAX_COLUMNS * MUKCA_MAX_COLUMNS], g[MUKCA_MAX_COLUMNS];
    solve(b, p);
    for (int e = 0; e < b->n; e++) {
        const mukca_scored *s = b->entry[e].item;
        const int block = s->products->block;
        for (int k = 0; k < b->entry[e].count; k += block) {
            const int which = (b->entry[e].first + k) / block;
            take_block(G, g, b, p, e, k);
            s->value[which] = mukca_projector_block(G, g, s->candidate, p->residual, p->normal->dof,
                                                    &s->information[which]);
        }
    }
    b->n = b->width = 0;
}

static void put(batch *b, const mukca_scored *item, int first, int count)
{
    b->entry[b->n].item = item;
    b->entry[b->n].first = first;
    b->entry[b->n].count = count;
    b->entry[b->n++].at = b->width;
    b->width += count;
}

void mukca_projector_score(mukca_projector *p, const mukca_scored *item, int n)
{
    batch b = {0};
    for (int i = 0; i < n; i++)
        for (int first = 0; first < item[i].products->columns; first += MUKCA_BATCH) {
            const int rest = item[i].products->columns - first,
                      count = rest < MUKCA_BATCH ? rest : MUKCA_BATCH;
            if (b.width + count > MUKCA_BATCH) finish(&b, p);
            put(&b, &item[i], first, count);
            fill(&b, p, b.n - 1);
        }
    if (b.n) finish(&b, p);
}

void mukca_projector_ripple(double *value, mukca_projector *p, mukca_products *x, int joint)
{
    double information[MUKCA_RIPPLE_ORDERS];
    const mukca_candidate h = {.kind = MUKCA_CANDIDATE_EFFECT,
                               .joint = joint,
                               .effect = {.kind = MUKCA_EFFECT_GEAR_HARMONIC},
                               .terms = 2,
                               .unit = {MUKCA_WAVE_UNIT, MUKCA_WAVE_UNIT}};
    mukca_products_update(&(mukca_product_item){NULL, joint, x}, 1, p->m, p->normal, &p->scratch);
    mukca_projector_score(p, &(mukca_scored){x, &h, value + 2, information}, 1);
}

void mukca_projector_project(double *G, double *g, mukca_projector *p, int k,
                             const mukca_candidate *h)
{
    mukca_products *x = &p->own;
    batch b = {0};
    x->columns = x->block = k;
    mukca_products_of(x, h, p->m, p->normal, &p->scratch);
    put(&b, &(mukca_scored){.products = x}, 0, k);
    fill(&b, p, 0);
    solve(&b, p);
    take_block(G, g, &b, p, 0, 0);
}

/* Faults of one socket or row: columns -share(row) * identity, so sums over rows suffice. */
double mukca_projector_fault(mukca_projector *p, const mukca_candidate *h, double *information)
{
    const mukca_recording *r = &p->m->recording;
    const mukca_group *group = &r->groups[h->fault.group];
    const int d = r->dim, n = p->n;
    double T[3][512], G[9], g[3] = {0, 0, 0}, square = 0, mean = 0, last = 0;
    if (n > 512) return -HUGE_VAL;
    mukca_projector_rows(p);
    memset(T, 0, sizeof T);
    for (int i = 0; i < group->count; i++) {
        const double share = mukca_candidate_fault_share(h, r, r->order[group->start + i]);
        const int sample = group->start + i;
        square += share * (p->normal->diagonal[sample] * share +
                           (i ? 2 * p->normal->off[sample] * last : 0));
        last = share;
        if (share == 0) continue;
        if (group->socket >= 0) mean += p->normal->mean_weight[sample] * share;
        for (int c = 0; c < 3; c++) {
            const int at = (group->start + i) * d + c;
            const double *z = p->Zt + (size_t)at * (size_t)n;
            for (int k = 0; k < n; k++) T[c][k] -= share * z[k];
            g[c] -= share * p->u[at];
        }
    }
    /* mean is 0 in a pose log, which has no free mean */
    const double own_part = p->precision * (square - p->normal->ones[h->fault.group] * mean * mean);
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

void mukca_projector_aim(mukca_projector *p, const mukca_normal_equations *normal, double sigma)
{
    mukca_regression *m = p->m;
    const int n = normal->n;
    p->normal = normal;
    p->n = n;
    p->rows = m->recording.n_samples * m->recording.dim;
    p->have_rows = false;
    p->precision = 1 / (sigma * sigma);
    mukca_evidence_evaluate(&m->evidence, normal, sigma, NULL);
    memcpy(p->z, m->evidence.work, sizeof *p->z * (size_t)n);
    p->residual = fmax(m->evidence.quadratic, 1e-9);
    const double known = normal->distance_sigma * normal->distance_sigma;
    for (int k = 0; k < normal->n_pairs; k++)
        p->inverse[k] = 1 / (known + sigma * sigma * normal->variance[k]);
}
