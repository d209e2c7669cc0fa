/* Projection of the present model out of candidates' columns, and their scores. */
#include "diagnose/projector.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "math/four.h"

enum {
    EIGHT = 8,               /* right-hand sides solved together */
    FEW = 3,                 /* columns of most blocks: a function call costs more than the work */
    STRIDE = MUKCA_BATCH + 8 /* of T: a power of two would map its rows to few cache sets */
};

bool mukca_projector_create(mukca_projector *p, mukca_pool *pool, mukca_regression *m)
{
    const size_t rows = (size_t)m->recording.data->n_rows * (size_t)m->recording.dim,
                 n = (size_t)mukca_unknowns_capacity(&m->unknowns),
                 pairs = (size_t)m->recording.data->n_distances + 1;
    *p = (mukca_projector){.m = m,
                           .inverse = MUKCA_TAKE(pool, double, pairs),
                           .z = MUKCA_TAKE(pool, double, n),
                           .factor = MUKCA_TAKE(pool, double, n + 1),
                           .distance = MUKCA_TAKE(pool, double, pairs *(n + 1)),
                           .along = MUKCA_TAKE(pool, double, pairs *STRIDE),
                           .T = MUKCA_TAKE(pool, double, (n + 1) * STRIDE),
                           .near = MUKCA_TAKE(pool, double, FEW *STRIDE),
                           .step.T = MUKCA_TAKE(pool, double, 3 * n),
                           .u = MUKCA_TAKE(pool, double, rows),
                           .Zt = MUKCA_TAKE(pool, double, rows *n)};
    return mukca_products_create(&p->own, pool, m, MUKCA_MAX_COLUMNS, MUKCA_MAX_COLUMNS) &&
           mukca_products_scratch(&p->scratch, pool, m);
}

/* D[3][n + 1] := right-hand sides, as in T, of the effect of a socket's mean on the distances. */
static void find_distances(double *D, const mukca_projector *p, int group)
{
    const mukca_recording *r = &p->m->recording;
    const int size = p->n + 1;
    memset(D, 0, sizeof *D * (size_t)(3 * size));
    for (int k = 0; k < r->n_pairs; k++) {
        const double *distance = p->distance + k * size,
                     sign = (r->pairs[k].a == group) - (r->pairs[k].b == group);
        for (int c = 0; c < 3 && sign != 0; c++)
            for (int t = 0; t < size; t++)
                D[c * size + t] += sign * p->m->linear.direction[k][c] * distance[t];
    }
}

/* B[n][8] := L^-1 B; next row, that of y: less the part explained by the model. */
static void solve_eight(double *B, const mukca_projector *p)
{
    const int n = p->n;
    mukca_dense_forward8(B, EIGHT, EIGHT, p->m->evidence.factor, n);
    for (int t = 0; t < n; t++)
        for (int k = 0; k < EIGHT; k++) B[EIGHT * n + k] -= B[EIGHT * t + k] * p->z[t];
}

/* Rows [start, start + count) of Zt := (L^-1 D (WX)')' and u := W y - Zt z, at most EIGHT of one
 * group. */
MUKCA_CLONES static void fill_rows(mukca_projector *p, const double *D, int start, int count)
{
    const int n = p->n, d = p->m->recording.dim, *at = p->m->linear.at;
    const size_t stride = (size_t)p->m->linear.stride;
    const double *row[EIGHT], *of_mean[EIGHT];
    double weight[EIGHT], *B = p->T, *Z = p->Zt + (size_t)start * (size_t)n;
    for (int k = 0; k < EIGHT; k++) {
        const int i = start + (k < count ? k : 0), c = i % d;
        row[k] = p->normal->weighted + (size_t)i * stride;
        of_mean[k] = D + (c < 3 ? c : 0) * (n + 1);
        weight[k] = c < 3 ? p->normal->mean_weight[i / d] : 0;
    }
    for (int t = 0; t <= n; t++)
        for (int k = 0; k < EIGHT; k++)
            B[EIGHT * t + k] = p->factor[t] * row[k][at[t]] + weight[k] * of_mean[k][t];
    solve_eight(B, p);
    for (int k = 0; k < count; k++) {
        for (int t = 0; t < n; t++) Z[(size_t)k * (size_t)n + (size_t)t] = B[EIGHT * t + k];
        p->u[start + k] = B[EIGHT * n + k];
    }
}

void mukca_projector_rows(mukca_projector *p)
{
    const mukca_recording *r = &p->m->recording;
    double *D = p->T + EIGHT * (p->n + 1);
    for (int g = 0; g < r->n_groups && !p->have_rows; g++) {
        const int start = r->dim * r->groups[g].start, count = r->dim * r->groups[g].count;
        find_distances(D, p, r->groups[g].socket >= 0 ? g : -1);
        for (int k = 0; k < count; k += EIGHT)
            fill_rows(p, D, start + k, count - k < EIGHT ? count - k : EIGHT);
    }
    p->have_rows = true;
}

/* Columns of several items side by side in T: right-hand sides D X'W E, then the row E'W y. */
typedef struct {
    int n, width;
    struct {
        const mukca_scored *item;
        int first, count, at; /* columns of the item, and their position in T */
    } entry[MUKCA_BATCH];
} batch;

/* Right-hand sides of an entry from the samples, and its effect on the distances.  Up to three
 * columns after it are overwritten: those of the next entry, not yet filled, or padding of T. */
MUKCA_CLONES static void fill(const batch *b, const mukca_projector *p, int e)
{
    const mukca_products *x = b->entry[e].item->products;
    const int n = p->n, first = b->entry[e].first, count = b->entry[e].count, at = b->entry[e].at,
              geometry = p->m->unknowns.n_geometry, *stored = p->m->linear.at;
    const double *cross = x->cross[0] + first;
    for (int t = 0; t <= n; t++, cross += x->columns) {
        if (t >= geometry) cross = mukca_products_row(x, stored[t]) + first;
        double *out = p->T + t * STRIDE + at;
        for (int k = 0; k < count; k += 4) STORE4(out + k, p->factor[t] * LOAD4(cross + k));
    }
    for (int q = 0; q < p->normal->n_pairs; q++)
        memcpy(p->along + q * STRIDE + at, x->along + q * x->columns + first,
               sizeof *p->along * (size_t)count);
}

/* Projected G[k][k] and g[k] of the block at `column` of an entry. */
MUKCA_CLONES static void project_block(double *G, double *g, const batch *b,
                                       const mukca_projector *p, int e, int column)
{
    const mukca_products *x = b->entry[e].item->products;
    const int k = x->block, first = b->entry[e].first + column, at = b->entry[e].at + column;
    double explained[MUKCA_MAX_COLUMNS * MUKCA_MAX_COLUMNS];
    memset(explained, 0, sizeof *explained * (size_t)(k * k));
    for (int a = 0; a < k; a++) g[a] = p->T[p->n * STRIDE + at + a];
    if (k > FEW) mukca_dense_syrk(explained, k, p->T + at, p->n, STRIDE);
    for (int a = 0; a < k && k <= FEW; a++)
        for (int c = 0; c <= a; c++)
            explained[a * k + c] = explained[c * k + a] = p->near[(a - c) * STRIDE + at + c];
    for (int a = 0; a < k; a++)
        for (int c = 0; c <= a; c++) {
            double sum = p->precision * x->gram[(first + a) * k + c] - explained[a * k + c];
            for (int q = 0; q < p->normal->n_pairs; q++)
                sum += p->inverse[q] * x->along[q * x->columns + first + a] *
                       x->along[q * x->columns + first + c];
            G[a * k + c] = G[c * k + a] = sum;
        }
}

/* g -= T'z; near[d][k] := product of columns k and k + d of T, for blocks of FEW columns or less.
 */
MUKCA_CLONES static void project(double *near, double *g, const double *T, const double *z, int n,
                                 int width)
{
    for (int k = 0; k < width; k += 4) {
        four explained = {0}, s[FEW] = {{0}};
        const double *row = T + k;
        for (int t = 0; t < n; t++, row += STRIDE) {
            const four x = LOAD4(row);
            explained += z[t] * x;
            s[0] += x * x;
            s[1] += x * LOAD4(row + 1);
            s[2] += x * LOAD4(row + 2);
        }
        STORE4(g + k, LOAD4(g + k) - explained);
        for (int d = 0; d < FEW; d++) STORE4(near + d * STRIDE + k, s[d]);
    }
}

/* Add the distances to the right-hand sides, solve, and project g, for the whole batch. */
static void solve(const batch *b, mukca_projector *p)
{
    const int width = (b->width + 7) & ~7, n = p->n; /* whole registers */
    for (int t = 0; t <= n; t++)
        for (int k = b->width; k < width; k++) p->T[t * STRIDE + k] = 0;
    for (int q = 0; q < p->normal->n_pairs; q++)
        for (int k = b->width; k < width; k++) p->along[q * STRIDE + k] = 0;
    mukca_dense_xty(p->T, (mukca_columns){p->distance, n + 1, n + 1},
                    (mukca_columns){p->along, STRIDE, STRIDE}, p->normal->n_pairs);
    mukca_dense_forward8(p->T, width, STRIDE, p->m->evidence.factor, n);
    project(p->near, p->T + n * STRIDE, p->T, p->z, n, width);
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
            project_block(G, g, b, p, e, k);
            s->value[which] = mukca_bayes_factor_average(G, g, s->candidate, p->residual,
                                                         p->normal->dof, &s->information[which]);
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
    project_block(G, g, &b, p, 0, 0);
}

/* Samples [from, to) of its group that a fault displaces, and the displacement of the group's mean:
 * 0 in a pose log, which has no free mean. */
typedef struct {
    int from, to;
    double mean;
} fault_span;

static void find_samples(fault_span *span, const mukca_recording *r, const mukca_candidate *h)
{
    const mukca_group *group = &r->groups[h->fault.group];
    const int end = group->start + group->count;
    int lo = group->start, hi = end;
    *span = (fault_span){lo, end, 0};
    if (h->kind == MUKCA_CANDIDATE_CREEP) return;
    while (lo < hi) { /* rows ascend within a group */
        const int middle = (lo + hi) / 2;
        if (r->order[middle] < h->fault.first)
            lo = middle + 1;
        else
            hi = middle;
    }
    span->from = lo;
    if (h->kind != MUKCA_CANDIDATE_OUTLIER) return;
    while (hi < end && r->order[hi] <= h->fault.last) hi++;
    span->to = hi;
}

/* T[3][n] and g[3] of a fault: sums over the rows of Zt and u. */
MUKCA_CLONES static void sum_rows(double *T, double *g, const mukca_projector *p,
                                  const mukca_candidate *h, const fault_span *span)
{
    const mukca_recording *r = &p->m->recording;
    for (int i = span->from; i < span->to; i++) {
        const double share = mukca_candidate_fault_share(h, r, r->order[i]);
        const double *z = p->Zt + (size_t)(i * r->dim) * (size_t)p->n, *u = p->u + i * r->dim;
        for (int k = 0; k < 3 * p->n && i == span->from; k++) T[k] = -share * z[k];
        for (int k = 0; k < 3 * p->n && i > span->from; k++) T[k] -= share * z[k];
        for (int c = 0; c < 3; c++) g[c] -= share * u[c];
    }
}

/* Sums over the rows for a step of the group at sample `from`.  If the previous step was earlier in
 * the same group, only the samples between the two are subtracted. */
MUKCA_CLONES static void sum_step(mukca_projector *p, int group, int from)
{
    const mukca_recording *r = &p->m->recording;
    const int end = r->groups[group].start + r->groups[group].count, d = r->dim, n = p->n;
    const bool follows = p->step.group == group && p->step.from <= from;
    const double sign = follows ? -1 : 1;
    double *T = p->step.T, *g = p->step.g;
    if (!follows) {
        memset(T, 0, sizeof *T * (size_t)(3 * n));
        p->step.square = p->step.mean = g[0] = g[1] = g[2] = 0;
    }
    const int first = follows ? p->step.from : from, last = follows ? from : end;
    for (int i = first; i < last; i++) {
        const double *z = p->Zt + (size_t)(i * d) * (size_t)n, *u = p->u + i * d;
        for (int k = 0; k < 3 * n; k++) T[k] -= sign * z[k];
        for (int c = 0; c < 3; c++) g[c] -= sign * u[c];
        p->step.square +=
            sign * (p->normal->diagonal[i] + (i + 1 < end ? 2 * p->normal->off[i + 1] : 0));
        p->step.mean += sign * p->normal->mean_weight[i];
    }
    p->step.group = group, p->step.from = from;
}

/* Weighted square of the shares of a fault's samples; span->mean receives their mean. */
static double weigh_shares(fault_span *span, const mukca_projector *p, const mukca_candidate *h)
{
    const mukca_recording *r = &p->m->recording;
    double square = 0, last = 0;
    for (int i = span->from; i < span->to; i++) {
        const double share = mukca_candidate_fault_share(h, r, r->order[i]);
        square += share * (p->normal->diagonal[i] * share +
                           (i > span->from ? 2 * p->normal->off[i] * last : 0));
        last = share;
        if (r->groups[h->fault.group].socket >= 0) span->mean += p->normal->mean_weight[i] * share;
    }
    return square;
}

/* G[3][3] := own identity - T T'. */
MUKCA_CLONES static void fault_gram(double G[9], double own, const double *T, int n)
{
    for (int a = 0; a < 3; a++)
        for (int b = 0; b <= a; b++)
            G[3 * a + b] = G[3 * b + a] = (a == b ? own : 0) - dot4(T + a * n, T + b * n, n);
}

/* Faults of one socket or sample: columns -share(sample) * identity. */
double mukca_projector_fault(mukca_projector *p, const mukca_candidate *h, double *information)
{
    const mukca_recording *r = &p->m->recording;
    const int n = p->n;
    double *T = p->T + (n + 1) * EIGHT, G[9], g[3] = {0}, square;
    fault_span span;
    find_samples(&span, r, h);
    if (h->kind == MUKCA_CANDIDATE_STEP) {
        sum_step(p, h->fault.group, span.from);
        T = p->step.T, square = p->step.square, span.mean = p->step.mean;
        memcpy(g, p->step.g, sizeof g);
    } else {
        square = weigh_shares(&span, p, h);
        sum_rows(T, g, p, h, &span);
    }
    const double own =
        p->precision * (square - p->normal->ones[h->fault.group] * span.mean * span.mean);
    fault_gram(G, own, T, n);
    for (int q = 0; q < r->n_pairs; q++) {
        const double *direction = p->m->linear.direction[q],
                     w = p->inverse[q] * span.mean * span.mean;
        if (r->pairs[q].a != h->fault.group && r->pairs[q].b != h->fault.group) continue;
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++) G[3 * a + b] += w * direction[a] * direction[b];
    }
    return mukca_bayes_factor_average(G, g, h, p->residual, p->normal->dof, information);
}

void mukca_projector_aim(mukca_projector *p, const mukca_normal_equations *normal, double sigma)
{
    mukca_regression *m = p->m;
    const int n = normal->n;
    /* with unchanged columns and priors the rows stay valid */
    bool same = p->have_rows && p->normal == normal && p->n == n && p->version == normal->version;
    p->version = normal->version;
    p->normal = normal;
    p->n = n;
    p->rows = m->recording.n_samples * m->recording.dim;
    p->step.group = -1;
    p->precision = 1 / (sigma * sigma);
    mukca_evidence_evaluate(&m->evidence, normal, sigma, NULL);
    same = same && memcmp(p->z, m->evidence.work, sizeof *p->z * (size_t)n) == 0;
    memcpy(p->z, m->evidence.work, sizeof *p->z * (size_t)n);
    p->residual = fmax(m->evidence.quadratic, 1e-9);
    for (int t = 0; t <= n; t++) {
        const double factor = p->precision * (t < n ? m->evidence.prior[t] : 1);
        same = same && p->factor[t] == factor;
        p->factor[t] = factor;
    }
    p->have_rows = same;
    const double known = normal->distance_sigma * normal->distance_sigma;
    for (int k = 0; k < normal->n_pairs; k++) {
        p->inverse[k] = 1 / (known + sigma * sigma * normal->variance[k]);
        for (int t = 0; t <= n; t++)
            p->distance[k * (n + 1) + t] = p->inverse[k] * normal->distance[k * (n + 1) + t] *
                                           (t < n ? m->evidence.prior[t] : 1);
    }
}
