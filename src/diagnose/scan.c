/* Scores of all candidate causes against the present model.
 *
 * With the model's whitened columns X (prior sigmas D) and 1 + D X'X D = L L', a candidate E has
 * the projected normal equations G = E'E - T'T and g = E'y - T'z, T = L^-1 D X'E, z = L^-1 D X'y
 * (block elimination; Golub and Van Loan, Matrix Computations, section 4.2). */
#include "diagnose/scan.h"

#include <math.h>
#include <string.h>

#include "infer/given.h"
#include "math/dense.h"

/* Log prior odds of a further member of a kin beyond those of a first: one flexible part in 30 is
 * as measurable as the first one. */
#define KINSHIP 3.0

enum { LD = MUKCA_SCAN_WIDTH };

bool mukca_scan_create(mukca_scan *s, mukca_pool *pool, mukca_regression *m, mukca_candidates *all)
{
    const mukca_recording *r = &m->recording;
    const size_t rows = (size_t)r->data->n_rows * (size_t)r->dim,
                 n = (size_t)mukca_unknowns_capacity(&m->unknowns) + 1,
                 pairs = (size_t)r->data->n_distances + 1;
    *s = (mukca_scan){.m = m,
                      .all = all,
                      .z = MUKCA_TAKE(pool, double, n),
                      .prior = MUKCA_TAKE(pool, double, n),
                      .link = MUKCA_TAKE(pool, double, pairs),
                      .start = MUKCA_TAKE(pool, int, all->capacity + 1),
                      .value = MUKCA_TAKE(pool, double, all->capacity),
                      .information = MUKCA_TAKE(pool, double, all->capacity)};
    s->batch = MUKCA_TAKE(pool, mukca_scan_batch, mukca_workers_count(m->recording.workers));
    for (int k = 0; k < mukca_workers_count(m->recording.workers) && !pool->failed; k++)
        s->batch[k] = (mukca_scan_batch){
            .W = MUKCA_TAKE(pool, double, (rows + pairs) * LD),
            .mean = MUKCA_TAKE(pool, double, (r->data->n_sockets + 2) * r->dim * LD),
            .C = MUKCA_TAKE(pool, double, n *LD),
            .T = MUKCA_TAKE(pool, double, n *LD),
            .g = MUKCA_TAKE(pool, double, LD),
            .scratch = MUKCA_TAKE(pool, mukca_mixture_scratch, 1)};
    return !pool->failed;
}

bool mukca_scan_aim(mukca_scan *s, int family)
{
    mukca_regression *m = s->m;
    mukca_evidence *evidence = &m->evidence;
    const double sigma = m->unknowns.sigma;
    mukca_regression_return(m);
    const mukca_normal_equations *normal = mukca_regression_collect(m, family);
    mukca_unknowns_prior(evidence->posterior.prior, &m->unknowns, -1);
    const double value = mukca_evidence_evaluate(evidence, normal, sigma, NULL);
    const int n = m->linear.n_columns, ld = m->linear.stride;
    s->normal = normal;
    s->white = mukca_evidence_whiten(evidence, normal);
    s->n = n;
    s->dof = normal->whitening.dof + normal->n_pairs;
    s->precision = 1 / (sigma * sigma);
    s->residual = fmax(evidence->posterior.quadratic, 1e-9);
    s->evidence = value + 0.5 * s->residual - 0.5 * s->dof * (log(s->residual / s->dof) + 1);
    memcpy(s->z, evidence->posterior.work, sizeof *s->z * (size_t)n);
    memcpy(s->prior, evidence->posterior.prior, sizeof *s->prior * (size_t)n);
    s->n_rows = m->recording.n_samples * m->recording.dim + normal->n_pairs;
    for (int p = 0; p < normal->n_pairs; p++) {
        const double *distance = normal->all_distance + p * ld;
        double *x = evidence->white.x + (s->n_rows - normal->n_pairs + p) * (long)ld;
        s->link[p] = 1 / sqrt(normal->variance[p]);
        for (int t = 0; t < n; t++) x[t] = s->link[p] * distance[t];
        x[m->linear.y] = s->link[p] * distance[ld - 1];
    }
    return isfinite(value);
}

/* C := X'E, and y'E behind it; T and g of the batch. */
static void project(const mukca_scan *s, const mukca_scan_batch *b)
{
    const mukca_recording *r = &s->m->recording;
    const mukca_linearisation *linear = &s->m->linear;
    const int width = (b->width + 7) & ~7, n = s->n, ld = linear->stride;
    const mukca_columns E = {b->W, width, LD};
    double *along = b->W + (size_t)(s->n_rows - r->n_pairs) * LD;
    memset(along, 0, sizeof *along * (size_t)(r->n_pairs * LD));
    mukca_whitening_apply(
        &(mukca_whitened){.n = b->width, .ld = LD, .x = b->W, .white = b->W, .mean = b->mean},
        &s->normal->whitening, &r->samples);
    mukca_evidence_along(along, b->mean, b->width, LD, linear);
    for (int p = 0; p < r->n_pairs; p++, along += LD) {
        for (int e = 0; e < b->n; e++)
            if (mukca_candidate_changes_pair(b->member[e], r, p))
                along[b->at[e]] = -1 / b->by[b->at[e]];
        for (int k = 0; k < width; k++) along[k] *= s->link[p];
    }
    memset(b->C, 0, sizeof *b->C * (size_t)((n + 1) * width));
    mukca_dense_xty(b->C, (mukca_columns){s->white, n, ld}, E, s->n_rows);
    mukca_dense_xty(b->C + n * width, (mukca_columns){s->white + linear->y, 1, ld}, E, s->n_rows);
    for (int t = 0; t <= n; t++) {
        double *out = t < n ? b->T + t * LD : b->g;
        const double *C = b->C + t * width, by = t < n ? s->prior[t] : 1;
        for (int k = 0; k < width; k++) out[k] = by * s->precision * b->by[k] * C[k];
    }
    mukca_dense_forward8(b->T, width, LD, s->m->evidence.posterior.factor, n);
    for (int t = 0; t < n; t++)
        for (int k = 0; k < width; k++) b->g[k] -= b->T[t * LD + k] * s->z[t];
}

/* Products of neighbouring members, from `first` on, of the batch: in b->scratch, E'E in C and T'T
 * in D.  Returns the member behind them; *width: of their columns. */
static int multiply(const mukca_scan *s, const mukca_scan_batch *b, int first, int *width)
{
    const int at = b->at[first];
    int end = first;
    *width = 0;
    do *width += b->member[end++]->terms;
    while (end < b->n && *width + b->member[end]->terms <= MUKCA_NEIGHBOURS);
    const mukca_columns w = {b->W + at, *width, LD}, t = {b->T + at, *width, LD};
    const size_t size = sizeof(double) * (size_t)(*width * *width);
    mukca_dense_symmetric(memset(b->scratch->C, 0, size), w, w, s->n_rows);
    mukca_dense_symmetric(memset(b->scratch->D, 0, size), t, t, s->n);
    return end;
}

/* G[terms][terms] of a member among neighbours. */
static void gram_of(double *G, const mukca_scan *s, const mukca_scan_batch *b, int member,
                    int first, int width)
{
    const int k = b->member[member]->terms, from = b->at[member] - b->at[first];
    const double *by = b->by + b->at[member];
    for (int i = 0; i < k; i++)
        for (int j = 0; j < k; j++) {
            const int at = (from + i) * width + from + j;
            G[i * k + j] = s->precision * by[i] * by[j] * b->scratch->C[at] - b->scratch->D[at];
        }
}

/* Append a candidate's columns to the batch. */
static void put(mukca_scan_batch *b, const mukca_scan *s, const mukca_candidate *h)
{
    mukca_linearisation_columns(b->W + b->width, LD, &s->m->linear, h);
    for (int t = 0; t < h->terms; t++) b->by[b->width + t] = 1 / h->unit[t];
    b->member[b->n] = h;
    b->at[b->n++] = b->width;
    b->width += h->terms;
}

/* Divide candidates, list[index[n]] or (NULL) those of list[n] that skip[] (NULL: none) does not
 * mark, into batches, which begin at s->start[]; returns their number. */
static int divide(const mukca_scan *s, const mukca_candidate *list, const int *index,
                  const unsigned char *skip, int n)
{
    int batches = 0;
    for (int i = 0, width = LD; i < n; i++) {
        const mukca_candidate *h = &list[index ? index[i] : i];
        if (skip && skip[i]) continue;
        if (width + h->terms > LD) s->start[batches++] = i, width = 0;
        width += h->terms;
    }
    s->start[batches] = n;
    return batches;
}

typedef struct {
    mukca_scan *scan;
    const mukca_candidate *list;
    const unsigned char *skip;
    double *value, *information;
} scoring;

static void score_batch(void *context, int block, int worker)
{
    const scoring *job = context;
    const mukca_scan *s = job->scan;
    mukca_scan_batch *b = &job->scan->batch[worker];
    double *G = b->scratch->A;
    b->n = b->width = 0;
    for (int i = s->start[block]; i < s->start[block + 1]; i++)
        if (!(job->skip && job->skip[i])) put(b, s, &job->list[i]);
    project(s, b);
    for (int e = 0, first = 0, end = 0, width = 0; e < b->n; e++) {
        const mukca_candidate *h = b->member[e];
        const mukca_mixture prior = mukca_candidate_mixture(h);
        double most = 0;
        if (e == end) end = multiply(s, b, first = e, &width);
        gram_of(G, s, b, e, first, width);
        for (int t = 0; t < mukca_candidate_own_terms(h); t++)
            most = fmax(most, G[t * h->terms + t]);
        job->information[h - job->list] = most;
        const mukca_equations columns = {G, b->g + b->at[e], h->terms, s->dof, s->residual};
        job->value[h - job->list] = mukca_mixture_evidence(NULL, &columns, &prior, b->scratch);
    }
}

/* NOLINTNEXTLINE(readability-non-const-parameter): written by the workers */
void mukca_scan_score(double *value, double *information, mukca_scan *s,
                      const mukca_candidate *list, const unsigned char *skip, int n)
{
    scoring job = {s, list, skip, value, information};
    mukca_workers_run(s->m->recording.workers, divide(s, list, NULL, skip, n), score_batch, &job);
}

typedef struct {
    mukca_scan *scan;
    const int *index;
    const mukca_item *item;
    double *E, *g;
} filling;

/* Columns of a batch, whitened, in units of the noise, and behind them what the model absorbs. */
static void fill_batch(void *context, int block, int worker)
{
    const filling *f = context;
    const mukca_scan *s = f->scan;
    mukca_scan_batch *b = &f->scan->batch[worker];
    const double root = sqrt(s->precision);
    const int first = s->start[block], at = f->item[first].at;
    b->n = b->width = 0;
    for (int i = first; i < s->start[block + 1]; i++) put(b, s, &s->all->list[f->index[i]]);
    project(s, b);
    memcpy(f->g + at, b->g, sizeof *b->g * (size_t)b->width);
    for (int k = 0, count; k < b->width; k += count) {
        const int all = s->n_rows + s->n, from = (at + k) % MUKCA_PANEL, left = b->width - k;
        double *out = f->E + (size_t)(at + k - from) * (size_t)all + from;
        count = left < MUKCA_PANEL - from ? left : MUKCA_PANEL - from;
        for (int row = 0; row < all; row++, out += MUKCA_PANEL)
            for (int c = 0; c < count; c++)
                out[c] = row < s->n_rows ? root * b->by[k + c] * b->W[row * LD + k + c]
                                         : b->T[(row - s->n_rows) * LD + k + c];
    }
}

/* Key of the candidates of which a set contains one at most: variants of one cause. */
static int key_of(const mukca_candidate *h)
{
    const int class = mukca_candidate_class(h);
    int at = h->joint + 1, place = 0; /* place: what distinguishes causes of a class at a joint */
    if (mukca_candidate_is_fault(h)) {
        at = h->fault.group, place = h->fault.first;
    } else if (mukca_effect_has(class, MUKCA_TRAIT_ORDERS)) {
        place = h->effect.variant.order;
    } else if (class == MUKCA_CLASS_UNKNOWN) {
        const bool step = mukca_unlisted_functions[h->unlisted.function].shape == MUKCA_SHAPE_STEP;
        place = h->unlisted.function * MUKCA_PLACES + (int)h->unlisted.place;
        if (step) place = MUKCA_UNLISTED_FUNCTIONS * MUKCA_PLACES + (int)h->unlisted.measure;
        if (h->joint < 0) at = h->placement + 1;
    } else {
        place = h->placement + 1;
    }
    return (place * 2 * MUKCA_MAX_JOINTS + at) * MUKCA_CLASSES + class;
}

bool mukca_scan_question(mukca_question *question, mukca_scan *s, mukca_pool *pool,
                         const int *index, int n)
{
    int columns = 0;
    for (int i = 0; i < n; i++) columns += s->all->list[index[i]].terms;
    const int stride = ((columns + 7) | 8) & ~7, all = s->n_rows + s->n;
    mukca_item *item = MUKCA_TAKE(pool, mukca_item, n + 1);
    filling f = {.scan = s,
                 .index = index,
                 .item = item,
                 .E = MUKCA_TAKE(pool, double, (size_t)all *(size_t)stride + 1),
                 .g = MUKCA_TAKE(pool, double, stride + 1)};
    if (pool->failed) return false;
    for (int i = 0, at = 0; i < n; at += item[i++].terms) {
        const mukca_candidate *h = &s->all->list[index[i]];
        item[i] = (mukca_item){
            .at = at,
            .terms = h->terms,
            .prior = mukca_candidate_mixture(h),
            .log_prior = h->log_prior - MUKCA_SET_RATE,
            .key = key_of(h),
            .kin = h->kind == MUKCA_CANDIDATE_EFFECT ? mukca_effect_kin(&h->effect) : 0,
            .kinship = KINSHIP};
    }
    mukca_workers_run(s->m->recording.workers, divide(s, s->all->list, index, NULL, n), fill_batch,
                      &f);
    *question = (mukca_question){.n_items = n,
                                 .n_columns = columns,
                                 .stride = stride,
                                 .n_rows = all,
                                 .n_projected = s->n,
                                 .item = item,
                                 .E = f.E,
                                 .g = f.g,
                                 .residual = s->residual,
                                 .dof = s->dof,
                                 .workers = s->m->recording.workers};
    return true;
}

/* E - X D u with u = (1 + D X'X D)^-1 D X'E = L'^-1 T. */
bool mukca_scan_leave(mukca_question *q, const mukca_scan *s, mukca_pool *pool)
{
    const mukca_recording *r = &s->m->recording;
    const int rows = r->n_samples * r->dim, stride = q->stride;
    const double root = sqrt(s->precision);
    double *u = MUKCA_TAKE(pool, double, s->n *stride + 1), *E;
    E = MUKCA_TAKE(pool, double, (size_t)rows *(size_t)stride + 1);
    if (pool->failed) return false;
    mukca_question_copy(u, stride, q, (mukca_span){0, stride}, (mukca_span){s->n_rows, s->n});
    mukca_dense_backward(u, stride, s->m->evidence.posterior.factor, s->n);
    for (int t = 0; t < s->n; t++)
        for (int k = 0; k < stride; k++) u[t * stride + k] *= root * s->prior[t];
    for (int at = 0; at < stride; at += MUKCA_PANEL)
        for (long i = 0; i < rows; i++) {
            const double *x = s->white + i * s->m->linear.stride;
            double *e = E + (long)at * rows + i * MUKCA_PANEL;
            memcpy(e, q->E + (long)at * q->n_rows + i * MUKCA_PANEL, sizeof *e * MUKCA_PANEL);
            for (int t = 0; t < s->n; t++)
                for (int k = 0; k < MUKCA_PANEL; k++) e[k] -= x[t] * u[t * stride + at + k];
        }
    q->E = E;
    q->n_rows = rows;
    q->n_projected = 0;
    return true;
}
