/* Products of candidates' columns with each other and with the stored columns. */
#include "diagnose/products.h"

#include <math.h>
#include <string.h>

#include "base/clones.h"
#include "math/dense.h"
#include "math/four.h"

enum { NEAR = 3 }; /* columns of most blocks */

bool mukca_products_scratch(mukca_product_scratch *s, mukca_pool *pool, const mukca_regression *m)
{
    const mukca_dataset *data = m->recording.data;
    const size_t rows = (size_t)data->n_rows, d = (size_t)m->recording.dim,
                 size = (size_t)mukca_unknowns_capacity(&m->unknowns) + 1;
    *s = (mukca_product_scratch){
        .E = MUKCA_TAKE(pool, double, rows *d *MUKCA_BATCH + 2 * NEAR),
        .W = MUKCA_TAKE(pool, double, rows *d *MUKCA_BATCH + 2 * NEAR),
        .U = MUKCA_TAKE(pool, double, rows *size),
        .C = MUKCA_TAKE(pool, double, size *MUKCA_BATCH),
        .along = MUKCA_TAKE(pool, double, (data->n_distances + 1) * MUKCA_BATCH),
        .mean = MUKCA_TAKE(pool, double, (data->n_sockets + 2) * 3 * MUKCA_BATCH),
        .tri = MUKCA_TAKE(pool, double, 2 * rows),
        .wave = {.sine = MUKCA_TAKE(pool, double, rows),
                 .cosine = MUKCA_TAKE(pool, double, rows),
                 .first = MUKCA_TAKE(pool, double, 2 * rows)}};
    return !pool->failed;
}

/* Memory of all members but `cross`. */
static bool allocate(mukca_products *x, mukca_pool *pool, const mukca_regression *m, int columns,
                     int block)
{
    const int pairs = m->recording.data->n_distances + 1;
    *x = (mukca_products){.columns = columns,
                          .block = block,
                          .gram = MUKCA_TAKE(pool, double, columns *(block + pairs))};
    x->along = x->gram + columns * block;
    return !pool->failed;
}

/* Append a piece to `cross`, with three spare entries: it is read four at a time. */
static bool grow(mukca_products *x, mukca_pool *pool, int rows)
{
    const int piece = x->rows ? 1 + (x->rows - x->first) / MUKCA_PRODUCT_ROWS : 0;
    x->cross[piece] = MUKCA_TAKE(pool, double, (size_t)rows *(size_t)x->columns + 3);
    if (!piece) x->first = rows;
    x->rows += rows;
    return x->cross[piece] != NULL;
}

bool mukca_products_create(mukca_products *x, mukca_pool *pool, const mukca_regression *m,
                           int columns, int block)
{
    return allocate(x, pool, m, columns, block) &&
           grow(x, pool, mukca_unknowns_capacity(&m->unknowns) + 1);
}

bool mukca_products_reserve(mukca_products *x, mukca_pool *pool, const mukca_regression *m,
                            int columns)
{
    if (pool->failed || (!x->columns && !allocate(x, pool, m, columns, columns))) return false;
    while (x->rows < m->linear.n_stored)
        if (!grow(x, pool, x->rows ? MUKCA_PRODUCT_ROWS : m->linear.n_stored)) return false;
    return true;
}

/* Columns of one or more items side by side in E, `width` of them. */
typedef struct {
    int n, width, start; /* entries; columns; first stored column they lack */
    struct {
        mukca_products *products;
        int first, count, at; /* columns of the products, and their position in E */
    } entry[MUKCA_BATCH];
} batch;

typedef struct {
    const mukca_regression *m;
    const mukca_normal_equations *normal;
    const mukca_product_scratch *s;
    int joint;     /* -1: columns of the observations; else functions of this joint */
    mukca_span of; /* samples in E */
    batch b;
} job;

/* Samples in which W X is not 0 for the stored columns from `start` on: a fault's are those of its
 * socket. */
static mukca_span find_samples(const mukca_linearisation *linear, const mukca_recording *r,
                               int start)
{
    mukca_span of = {r->n_samples, 0};
    int columns = 0;
    for (int c = 0; c < linear->n_causes; c++) {
        const mukca_candidate *h = &linear->cause[c];
        if (linear->at_cause[c] < start || !mukca_candidate_is_fault(h)) continue;
        const mukca_group *group = &r->groups[h->fault.group];
        if (group->start < of.start) of.start = group->start;
        if (group->start + group->count > of.end) of.end = group->start + group->count;
        columns += h->terms;
    }
    return start + columns == linear->n_stored ? of : (mukca_span){0, r->n_samples};
}

/* Entries of W'E within blocks of NEAR columns: of_w[d][k], column k of W times column k + d of E;
 * of_e[d][k], column k of E times column k + d of W.  k runs to the next multiple of four. */
MUKCA_CLONES static void multiply_near(double *of_w, double *of_e, const double *W, const double *E,
                                       int width, int rows)
{
    for (int k = 0; k < width; k += 4) {
        four w[NEAR] = {{0}}, e[NEAR] = {{0}};
        const double *x = W + k, *y = E + k;
        for (int r = 0; r < rows; r++, x += width, y += width)
            for (int d = 0; d < NEAR; d++) {
                w[d] += LOAD4(x) * LOAD4(y + d);
                e[d] += LOAD4(y) * LOAD4(x + d);
            }
        for (int d = 0; d < NEAR; d++) {
            STORE4(of_w + d * MUKCA_BATCH + k, w[d]);
            STORE4(of_e + d * MUKCA_BATCH + k, e[d]);
        }
    }
}

/* Distribute C (products with the stored columns), E'W E and `along` to the batch's entries. */
static void distribute(const job *j)
{
    const batch *b = &j->b;
    const int stored = j->m->linear.n_stored, d = j->joint < 0 ? j->m->recording.dim : 1,
              rows = (j->of.end - j->of.start) * d;
    double of_w[NEAR * MUKCA_BATCH], of_e[NEAR * MUKCA_BATCH];
    if (!b->start) multiply_near(of_w, of_e, j->s->W, j->s->E, b->width, rows);
    for (int e = 0; e < b->n; e++) {
        mukca_products *x = b->entry[e].products;
        const int first = b->entry[e].first, count = b->entry[e].count, at = b->entry[e].at;
        for (int i = b->start; i < stored; i++)
            memcpy(mukca_products_row(x, i) + first,
                   j->s->C + (size_t)(i - b->start) * (size_t)b->width + at,
                   sizeof *j->s->C * (size_t)count);
        if (b->start) continue;
        for (int k = 0; k < count; k += x->block) {
            double *G = x->gram + (first + k) * x->block;
            memset(G, 0, sizeof *G * (size_t)(x->block * x->block));
            if (x->block > NEAR)
                mukca_dense_xty(G, (mukca_columns){j->s->W + at + k, x->block, b->width},
                                (mukca_columns){j->s->E + at + k, x->block, b->width}, rows);
            for (int a = 0; a < x->block && x->block <= NEAR; a++)
                for (int c = 0; c < x->block; c++)
                    G[a * x->block + c] = c < a ? of_e[(a - c) * MUKCA_BATCH + at + k + c]
                                                : of_w[(c - a) * MUKCA_BATCH + at + k + a];
        }
        for (int p = 0; p < j->m->recording.n_pairs; p++)
            memcpy(x->along + p * x->columns + first, j->s->along + p * b->width + at,
                   sizeof *x->along * (size_t)count);
    }
}

/* Products of columns of the observations. */
static void finish_columns(const job *j)
{
    const mukca_regression *m = j->m;
    const mukca_product_scratch *s = j->s;
    const int width = j->b.width, start = j->b.start, stored = m->linear.n_stored,
              d = m->recording.dim, ld = m->linear.stride;
    if (!start) {
        memset(s->along, 0, sizeof *s->along * (size_t)(m->recording.n_pairs * width));
        mukca_evidence_weigh(
            &(mukca_weighing){
                .n = width, .ld = width, .x = s->E, .weighted = s->W, .along = s->along},
            j->normal, &m->recording, &m->linear);
    }
    memset(s->C, 0, sizeof *s->C * (size_t)((stored - start) * width));
    const double *weighted = j->normal->weighted + (size_t)(j->of.start * d) * (size_t)ld + start;
    mukca_dense_xty(s->C, (mukca_columns){weighted, stored - start, ld},
                    (mukca_columns){s->E, width, width}, (j->of.end - j->of.start) * d);
    distribute(j);
}

/* Project W, and W X from stored column `start` on, on the levers of the joint. */
MUKCA_CLONES static void project_levers(const job *j, int start)
{
    const mukca_regression *m = j->m;
    const mukca_recording *r = &m->recording;
    const int d = r->dim, n_joints = r->chain->n_joints, n = m->linear.n_stored - start;
    double *diagonal = j->s->tri, *off = diagonal + r->n_samples;
    const mukca_span of = find_samples(&m->linear, r, start);
    for (int i = of.start; i < of.end; i++) {
        const double *lever = m->linear.lever + (size_t)(i * n_joints + j->joint) * (size_t)d;
        double square = 0, product = 0, *u = j->s->U + (size_t)i * (size_t)n;
        memset(u, 0, sizeof *u * (size_t)n);
        for (int c = 0; c < d; c++) {
            const double *w =
                j->normal->weighted + (size_t)(i * d + c) * (size_t)m->linear.stride + start;
            for (int k = 0; k < n; k++) u[k] += lever[c] * w[k];
            square += lever[c] * lever[c];
            if (j->normal->off[i] < 0) product += lever[c] * lever[c - n_joints * d];
        }
        diagonal[i] = square * j->normal->diagonal[i];
        off[i] = 2 * product * j->normal->off[i];
    }
}

/* Effect of the joint's functions E[n_samples][width] on the means of the sockets. */
MUKCA_CLONES static void find_means(const job *j, int width)
{
    const mukca_regression *m = j->m;
    const mukca_recording *r = &m->recording;
    const int d = r->dim, n_joints = r->chain->n_joints;
    for (int g = 0; g < r->n_groups; g++) {
        const mukca_group *group = &r->groups[g];
        double *mean = j->s->mean + (size_t)(3 * g) * (size_t)width;
        memset(mean, 0, sizeof *mean * (size_t)(3 * width));
        for (int i = group->start; i < group->start + group->count && group->socket >= 0; i++) {
            const double *lever = m->linear.lever + (size_t)(i * n_joints + j->joint) * (size_t)d;
            const double *f = j->s->E + (size_t)i * (size_t)width;
            for (int c = 0; c < 3; c++) {
                const double w = j->normal->mean_weight[i] * lever[c];
                for (int k = 0; k < width; k++) mean[c * width + k] += w * f[k];
            }
        }
    }
}

/* Products of functions that rotate the joint: the levers reduce the rows of a sample to one. */
MUKCA_CLONES static void finish_functions(const job *j, int aimed)
{
    const mukca_regression *m = j->m;
    const mukca_recording *r = &m->recording;
    const mukca_product_scratch *s = j->s;
    const int width = j->b.width, start = j->b.start, stored = m->linear.n_stored;
    memset(s->C, 0, sizeof *s->C * (size_t)((stored - start) * width));
    const double *U = s->U + (size_t)j->of.start * (size_t)(stored - aimed) + (start - aimed);
    mukca_dense_xty(s->C, (mukca_columns){U, stored - start, stored - aimed},
                    (mukca_columns){s->E, width, width}, j->of.end - j->of.start);
    if (!start) {
        const double *diagonal = s->tri, *off = diagonal + r->n_samples;
        for (int i = 0; i < r->n_samples; i++) {
            const double *f = s->E + (size_t)i * (size_t)width;
            double *h = s->W + (size_t)i * (size_t)width;
            for (int k = 0; k < width; k++) h[k] = diagonal[i] * f[k];
            for (int k = 0; k < width && off[i] != 0; k++) h[k] += off[i] * f[k - width];
        }
        find_means(j, width);
        for (int p = 0; p < r->n_pairs; p++)
            for (int k = 0; k < width; k++) {
                const double *a = s->mean + 3 * r->pairs[p].a * width + k,
                             *b = s->mean + 3 * r->pairs[p].b * width + k;
                double sum = 0;
                for (int c = 0; c < 3; c++)
                    sum += m->linear.direction[p][c] * (a[c * width] - b[c * width]);
                s->along[p * width + k] = sum;
            }
    }
    distribute(j);
    for (int e = 0; e < j->b.n && !start; e++) { /* subtract the sockets' means */
        mukca_products *x = j->b.entry[e].products;
        const int block = x->block;
        for (int k = 0; k < j->b.entry[e].count; k += block) {
            double *G = x->gram + (j->b.entry[e].first + k) * block;
            for (int g = 0; g < 3 * r->n_groups; g++) {
                const double *mean = s->mean + g * width + j->b.entry[e].at + k,
                             w = j->normal->ones[g / 3];
                if (r->groups[g / 3].socket < 0) continue;
                for (int a = 0; a < block; a++)
                    for (int b = 0; b < block; b++) G[a * block + b] -= w * mean[a] * mean[b];
            }
            for (int a = 0; a < block; a++) /* `off` has both triangles in one: average them */
                for (int b = 0; b < a; b++)
                    G[a * block + b] = G[b * block + a] =
                        0.5 * (G[a * block + b] + G[b * block + a]);
        }
    }
}

static void put(batch *b, mukca_products *x, int first, int count)
{
    b->entry[b->n].products = x;
    b->entry[b->n].first = first;
    b->entry[b->n].count = count;
    b->entry[b->n++].at = b->width;
    b->width += count;
}

/* Fill E with the functions of the batch's candidates, four at a time: numbers written after the
 * last term are overwritten by the next candidate or sample. */
MUKCA_CLONES static void fill_functions(const job *j, const mukca_candidate *const *candidate)
{
    const int *order = j->m->recording.order;
    double *E = j->s->E;
    for (int i = j->of.start; i < j->of.end; i++)
        for (int e = 0; e < j->b.n; e++) {
            const int terms = j->b.entry[e].count;
            const float *basis = candidate[e]->basis + (size_t)order[i] * (size_t)terms;
            for (int t = 0; t < terms; t += 4) STORE4(E + t, WIDEN4(basis + t));
            E += terms;
        }
}

/* Fill E with the candidates of the batch, side by side. */
static void fill(const job *j, const mukca_candidate *const *candidate)
{
    const mukca_recording *r = &j->m->recording;
    if (j->joint >= 0) {
        fill_functions(j, candidate);
        return;
    }
    for (int e = 0; e < j->b.n; e++)
        mukca_linearisation_columns_of(j->s->E + j->b.entry[e].at, j->b.width, &j->m->linear, r,
                                       candidate[e], j->of);
}

void mukca_products_ripple(mukca_products *x, int joint, const int *order,
                           const mukca_regression *m, const mukca_normal_equations *normal,
                           const mukca_product_scratch *s)
{
    job j = {.m = m, .normal = normal, .s = s, .joint = joint, .of = {0, m->recording.n_samples}};
    mukca_ripple wave = s->wave;
    project_levers(&j, 0);
    mukca_ripple_start(&wave, &m->recording, joint);
    for (int first = 0; first < x->columns; first += MUKCA_BATCH) {
        const int count = x->columns - first < MUKCA_BATCH ? x->columns - first : MUKCA_BATCH;
        j.b.n = j.b.width = 0;
        put(&j.b, x, first, count);
        mukca_ripple_fill(s->E, &wave, order + first / 2, count / 2);
        finish_functions(&j, 0);
    }
    x->version = m->linear.version;
    x->done = m->linear.n_stored;
}

/* Direct effect of a candidate on the distances. */
static void change_pairs(mukca_products *x, const mukca_candidate *h, const mukca_recording *r)
{
    for (int p = 0; p < r->n_pairs; p++)
        if (mukca_candidate_changes_pair(h, r, p)) x->along[p * x->columns] = -1;
}

void mukca_products_update(const mukca_product_item *item, int n, const mukca_regression *m,
                           const mukca_normal_equations *normal, const mukca_product_scratch *s)
{
    const mukca_candidate *candidate[MUKCA_BATCH];
    const int stored = m->linear.n_stored;
    job j = {.m = m, .normal = normal, .s = s, .joint = -1};
    int aimed = 0; /* first stored column in U */
    for (int i = 0; i < n; i++)
        if (item[i].products->version != m->linear.version)
            item[i].products->version = m->linear.version, item[i].products->done = 0;
    for (int i = 0; i < n;) {
        const mukca_products *x = item[i].products;
        if (x->done == stored) {
            i++;
            continue;
        }
        if (item[i].joint >= 0 && (item[i].joint != j.joint || x->done < aimed)) {
            j.joint = item[i].joint;
            aimed = x->done;
            for (int k = i; k < n && item[k].joint == j.joint; k++)
                if (item[k].products->done < aimed) aimed = item[k].products->done;
            project_levers(&j, aimed);
        }
        j.joint = item[i].joint;
        j.b.n = j.b.width = 0;
        j.b.start = x->done;
        const int room = j.joint < 0 ? MUKCA_BATCH / m->recording.dim : MUKCA_BATCH;
        j.of = find_samples(&m->linear, &m->recording, x->done);
        for (; i < n && item[i].joint == j.joint; i++) {
            mukca_products *next = item[i].products;
            if (next->done == stored) continue;
            if (next->done != j.b.start || (j.b.n && j.b.width + next->columns > room)) break;
            candidate[j.b.n] = item[i].candidate;
            put(&j.b, next, 0, next->columns);
        }
        fill(&j, candidate);
        if (j.joint < 0)
            finish_columns(&j);
        else
            finish_functions(&j, aimed);
        for (int e = 0; e < j.b.n; e++) {
            mukca_products *done = j.b.entry[e].products;
            done->done = stored;
            change_pairs(done, candidate[e], &m->recording);
        }
    }
}

void mukca_products_of(mukca_products *x, const mukca_candidate *h, const mukca_regression *m,
                       const mukca_normal_equations *normal, const mukca_product_scratch *s)
{
    job j = {.m = m, .normal = normal, .s = s, .joint = -1, .of = {0, m->recording.n_samples}};
    put(&j.b, x, 0, x->columns);
    x->version = m->linear.version;
    x->done = m->linear.n_stored;
    finish_columns(&j);
    change_pairs(x, h, &m->recording);
}
