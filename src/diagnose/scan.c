/* Scores of all candidate causes against the present model.
 *
 * With the model's whitened columns X (prior sigmas D) and 1 + D X'X D = L L', a candidate E has
 * the projected normal equations G = E'E - T'T and g = E'y - T'z, T = L^-1 D X'E, z = L^-1 D X'y
 * (block elimination; Golub and Van Loan, Matrix Computations, section 4.2). */
#include "diagnose/scan.h"

#include <math.h>
#include <string.h>

#include "base/clones.h"
#include "diagnose/ripple.h"
#include "math/dense.h"
#include "math/four.h"

/* Log prior odds of a further member of a kin beyond those of a first: one flexible part in 30 is
 * as measurable as the first one. */
#define KINSHIP 3.0

enum {
    LD = MUKCA_SCAN_WIDTH,
    NEAR = 3 /* columns of most blocks */
};

bool mukca_scan_create(mukca_scan *s, mukca_pool *pool, mukca_regression *m, mukca_candidates *all)
{
    const mukca_recording *r = &m->recording;
    const size_t rows = (size_t)r->data->n_rows * (size_t)r->dim,
                 n = (size_t)mukca_unknowns_capacity(&m->unknowns) + 1,
                 pairs = (size_t)r->data->n_distances + 1;
    *s = (mukca_scan){
        .m = m,
        .all = all,
        .z = MUKCA_TAKE(pool, double, n),
        .prior = MUKCA_TAKE(pool, double, n),
        .inverse = MUKCA_TAKE(pool, double, pairs),
        .distance = MUKCA_TAKE(pool, double, pairs *n),
        .E = MUKCA_TAKE(pool, double, rows *LD),
        .W = MUKCA_TAKE(pool, double, rows *LD + NEAR), /* read beyond the last column */
        .mean = MUKCA_TAKE(pool, double, (r->data->n_sockets + 2) * r->dim * LD),
        .along = MUKCA_TAKE(pool, double, pairs *LD + NEAR),
        .C = MUKCA_TAKE(pool, double, n *LD),
        .T = MUKCA_TAKE(pool, double, n *LD + NEAR),
        .g = MUKCA_TAKE(pool, double, LD),
        .near = MUKCA_TAKE(pool, double, NEAR *LD),
        .rows = MUKCA_TAKE(pool, double, (rows + 8) * n),
        .u = MUKCA_TAKE(pool, double, rows),
        .scratch = MUKCA_TAKE(pool, mukca_mixture_scratch, 1),
        .value = MUKCA_TAKE(pool, double, all->capacity),
        .information = MUKCA_TAKE(pool, double, all->capacity),
    };
    mukca_whitening_create(&s->plain, pool, r->data->n_rows, r->data->n_sockets + 2, 1);
    return !pool->failed;
}

bool mukca_scan_aim(mukca_scan *s, int family)
{
    mukca_regression *m = s->m;
    mukca_evidence *evidence = &m->evidence;
    const double sigma = m->unknowns.sigma;
    mukca_regression_return(m);
    const mukca_normal_equations *normal = mukca_regression_collect(m, family);
    mukca_unknowns_prior(evidence->posterior.prior, &m->unknowns);
    const double value = mukca_evidence_evaluate(evidence, normal, sigma, NULL);
    const int n = normal->n;
    s->normal = normal;
    s->white = mukca_evidence_whiten(evidence, normal, &m->recording, &m->linear);
    s->n = n;
    s->dof = normal->whitening.dof + normal->n_pairs;
    s->precision = 1 / (sigma * sigma);
    s->residual = fmax(evidence->posterior.quadratic, 1e-9);
    s->evidence = value + 0.5 * s->residual - 0.5 * s->dof * (log(s->residual / s->dof) + 1);
    memcpy(s->z, evidence->posterior.work, sizeof *s->z * (size_t)n);
    memcpy(s->prior, evidence->posterior.prior, sizeof *s->prior * (size_t)n);
    for (int p = 0; p < normal->n_pairs; p++) {
        s->inverse[p] = 1 / (normal->distance_sigma * normal->distance_sigma +
                             sigma * sigma * normal->variance[p]);
        memcpy(s->distance + p * (n + 1), normal->distance + p * (n + 1),
               sizeof *s->distance * (size_t)(n + 1));
    }
    return isfinite(value);
}

/* Candidates side by side in the scratch. */
typedef struct {
    int n, width, index[LD], at[LD];
} batch;

/* near[d][c] += sign * sum of x[r][c] x[r][c + d] over the rows, for blocks of NEAR columns. */
MUKCA_CLONES static void add_near(double *near, const double *x, int rows, int width, double by)
{
    for (int k = 0; k < width; k += 4) {
        four sum[NEAR] = {{0}};
        const double *row = x + k;
        for (int r = 0; r < rows; r++, row += LD) {
            const four own = LOAD4(row);
            for (int d = 0; d < NEAR; d++) sum[d] += own * LOAD4(row + d);
        }
        for (int d = 0; d < NEAR; d++)
            STORE4(near + d * LD + k, LOAD4(near + d * LD + k) + by * sum[d]);
    }
}

/* The same for the whole batch, after the projection. */
static void find_near(mukca_scan *s, int width)
{
    const mukca_recording *r = &s->m->recording;
    memset(s->near, 0, sizeof *s->near * NEAR * LD);
    add_near(s->near, s->W, r->n_samples * r->dim, width, s->precision);
    add_near(s->near, s->T, s->n, width, -1);
    for (int p = 0; p < r->n_pairs; p++)
        add_near(s->near, s->along + p * LD, 1, width, s->inverse[p]);
}

/* C := X'E, and y'E behind it; T and g of the batch. */
static void project(mukca_scan *s, const batch *b)
{
    const mukca_recording *r = &s->m->recording;
    const mukca_linearisation *linear = &s->m->linear;
    const int width = (b->width + 7) & ~7, n = s->n, ld = linear->stride,
              rows = r->n_samples * r->dim;
    const mukca_columns E = {s->W, width, LD};
    memset(s->along, 0, sizeof *s->along * (size_t)(r->n_pairs * LD));
    mukca_whitening_apply(
        &(mukca_whitened){.n = b->width, .ld = LD, .x = s->E, .white = s->W, .mean = s->mean},
        &s->normal->whitening, &r->samples);
    mukca_evidence_along(s->along, s->mean, b->width, LD, r, linear);
    for (int e = 0; e < b->n; e++)
        for (int p = 0; p < r->n_pairs; p++)
            if (mukca_candidate_changes_pair(&s->all->list[b->index[e]], r, p))
                s->along[p * LD + b->at[e]] = -1;
    memset(s->C, 0, sizeof *s->C * (size_t)((n + 1) * width));
    mukca_dense_xty(s->C, (mukca_columns){s->white, n, ld}, E, rows);
    mukca_dense_xty(s->C + n * width, (mukca_columns){s->white + linear->y, 1, ld}, E, rows);
    for (int t = 0; t <= n; t++) {
        double *out = t < n ? s->T + t * LD : s->g;
        const double *C = s->C + t * width, by = t < n ? s->prior[t] : 1;
        for (int k = 0; k < width; k++) out[k] = by * s->precision * C[k];
        for (int p = 0; p < r->n_pairs; p++) {
            const double w = by * s->inverse[p] * s->distance[p * (n + 1) + t];
            for (int k = 0; k < width && w != 0; k++) out[k] += w * s->along[p * LD + k];
        }
    }
    mukca_dense_forward8(s->T, width, LD, s->m->evidence.posterior.factor, n);
    for (int t = 0; t < n; t++)
        for (int k = 0; k < width; k++) s->g[k] -= s->T[t * LD + k] * s->z[t];
    find_near(s, width);
}

/* G[k][k] of the k columns from `at` on. */
static void gram_of(double *G, const mukca_scan *s, int at, int k)
{
    const mukca_recording *r = &s->m->recording;
    const int rows = r->n_samples * r->dim;
    for (int a = 0; a < k && k <= NEAR; a++)
        for (int c = 0; c <= a; c++) G[a * k + c] = G[c * k + a] = s->near[(a - c) * LD + at + c];
    if (k <= NEAR) return;
    const mukca_columns w = {s->W + at, k, LD}, t = {s->T + at, k, LD};
    double *explained = s->scratch->B;
    memset(G, 0, sizeof *G * (size_t)(k * k));
    memset(explained, 0, sizeof *G * (size_t)(k * k));
    mukca_dense_symmetric(G, w, w, rows);
    mukca_dense_symmetric(explained, t, t, s->n);
    for (int a = 0; a < k * k; a++) G[a] = s->precision * G[a] - explained[a];
    for (int p = 0; p < r->n_pairs; p++) {
        const double *x = s->along + p * LD + at;
        for (int a = 0; a < k; a++)
            for (int c = 0; c < k; c++) G[a * k + c] += s->inverse[p] * x[a] * x[c];
    }
}

static void finish(mukca_scan *s, batch *b)
{
    double *G = s->scratch->A;
    if (!b->n) return;
    project(s, b);
    for (int e = 0; e < b->n; e++) {
        const mukca_candidate *h = &s->all->list[b->index[e]];
        const mukca_mixture prior = mukca_candidate_mixture(h);
        double most = 0;
        gram_of(G, s, b->at[e], h->terms);
        for (int t = 0; t < mukca_candidate_own_terms(h); t++)
            most = fmax(most, G[t * h->terms + t]);
        s->information[b->index[e]] = most;
        s->value[b->index[e]] = mukca_mixture_evidence(NULL, G, s->g + b->at[e], h->terms, &prior,
                                                       s->residual, s->dof, s->scratch);
    }
    b->n = b->width = 0;
}

/* Append a candidate's columns, per unit size, to the batch. */
static void put(mukca_scan *s, batch *b, int index)
{
    const mukca_candidate *h = &s->all->list[index];
    const int rows = s->m->recording.n_samples * s->m->recording.dim;
    mukca_linearisation_columns(s->E + b->width, LD, &s->m->linear, &s->m->recording, h);
    for (int t = 0; t < h->terms; t++) {
        const double by = 1 / h->unit[t];
        double *column = s->E + b->width + t;
        for (int i = 0; i < rows && by != 1; i++) column[i * LD] *= by;
    }
    b->index[b->n] = index;
    b->at[b->n++] = b->width;
    b->width += h->terms;
}

/* Score candidates from `first` on. */
static void score_from(mukca_scan *s, int first)
{
    batch b = {0};
    for (int i = first; i < s->all->count; i++) {
        const mukca_candidate *h = &s->all->list[i];
        if (mukca_candidate_is_fault(h)) continue;
        if (b.width + h->terms > LD) finish(s, &b);
        put(s, &b, i);
    }
    finish(s, &b);
}

/* u[n_samples][dim]: products of the residual with columns that are not whitened.  Uses W and T. */
static void residual_products(double *u, mukca_scan *s)
{
    const mukca_recording *r = &s->m->recording;
    const mukca_linearisation *linear = &s->m->linear;
    const mukca_whitening *w = &s->normal->whitening;
    const int n = s->n, d = r->dim, ld = linear->stride;
    double *mean = s->T, *white = s->W; /* scratch */
    memcpy(mean, s->z, sizeof *mean * (size_t)n);
    mukca_dense_backward(mean, 1, s->m->evidence.posterior.factor, n);
    for (int t = 0; t < n; t++) mean[t] *= s->prior[t];
    for (int i = 0; i < r->n_samples * d; i++) {
        const double *x = s->white + (size_t)i * (size_t)ld;
        white[i] = x[linear->y];
        for (int t = 0; t < n; t++) white[i] -= x[t] * mean[t];
        white[i] *= s->precision;
    }
    for (int p = 0; p < r->n_pairs; p++) {
        const double *distance = s->distance + p * (n + 1);
        double rest = distance[n];
        for (int t = 0; t < n; t++) rest -= distance[t] * mean[t];
        for (int side = 0; side < 2; side++) {
            const int g = side ? r->pairs[p].b : r->pairs[p].a;
            const mukca_group *group = &r->groups[g];
            double x[6] = {0};
            for (int c = 0; c < 3; c++)
                x[c] = (side ? -1 : 1) * s->inverse[p] * rest * linear->direction[p][c];
            mukca_whitening_solve(x, w, g, d);
            for (int i = group->start * d; i < (group->start + group->count) * d; i++)
                for (int c = 0; c < d; c++) white[i] += w->one[i * d + c] * x[c];
        }
    }
    mukca_whitening_transpose(u, white, 1, 1, w, &r->samples);
}

/* Log odds, but for those of the joint and the class, of the orders of ripple of a joint that are
 * not yet listed.  The geometry absorbs little of a short wave: all have nearly the same
 * information, and the gradient is exact.  u: residual; along[n_samples]: scratch.  False: too
 * little travel. */
static bool guess_ripple(double *odds, mukca_scan *s, int j, const double *u, double *along)
{
    const mukca_recording *r = &s->m->recording;
    const mukca_whitening *w = &s->normal->whitening;
    const int N = r->n_samples, d = r->dim;
    double square = 0, travel[2];
    mukca_recording_travel(travel, r, j);
    if (!s->all->survey.joint[j].turns || travel[1] - travel[0] < MUKCA_RIPPLE_TRAVEL) return false;
    for (int i = 0; i < N; i++) {
        const double *lever = s->m->linear.lever + (i * r->chain->n_joints + j) * d,
                     of = w->level[i];
        along[i] = 0;
        for (int c = 0; c < d; c++) {
            along[i] += lever[c] * u[i * d + c];
            square += s->precision * of * of * lever[c] * lever[c];
        }
    }
    const double left = square * fmax(1 - (double)s->n / s->dof, 0.1); /* a wave has half, twice */
    mukca_ripple wave = {.sine = along + N, .cosine = along + 2 * N, .first = along + 3 * N};
    const mukca_mixture prior = mukca_candidate_mixture(
        &(mukca_candidate){.kind = MUKCA_CANDIDATE_EFFECT,
                           .effect.kind = MUKCA_EFFECT_GEAR_HARMONIC,
                           .unit = (const double[]){MUKCA_WAVE_UNIT, MUKCA_WAVE_UNIT},
                           .terms = 2});
    bool listed[MUKCA_RIPPLE_ORDERS + 1] = {false};
    for (int i = 0; i < s->all->count; i++) {
        const mukca_candidate *h = &s->all->list[i];
        if (h->joint == j && mukca_candidate_class(h) == MUKCA_EFFECT_GEAR_HARMONIC)
            listed[h->effect.variant.order] = true;
    }
    mukca_ripple_start(&wave, r, j);
    for (int o = 2; o <= MUKCA_RIPPLE_ORDERS; o++) {
        mukca_ripple_next(&wave);
        const double G[] = {left, 0, 0, left},
                     g[] = {dot4(along, wave.sine, N) / MUKCA_WAVE_UNIT,
                            dot4(along, wave.cosine, N) / MUKCA_WAVE_UNIT};
        odds[o] = listed[o] ? -HUGE_VAL
                            : mukca_ripple_log_prior(o) +
                                  mukca_mixture_evidence(NULL, G, g, 2, &prior, s->residual, s->dof,
                                                         s->scratch);
    }
    return true;
}

static mukca_status add_ripple(mukca_scan *s, mukca_error *error)
{
    enum { ADDED = 12 };
    const double least = -5; /* log odds below which an order is not listed */
    const mukca_recording *r = &s->m->recording;
    const int first = s->all->count;
    double *along = s->W;
    double *u = s->E;
    residual_products(u, s);
    for (int j = 0; j < r->chain->n_joints && s->all->harmonics; j++) {
        double odds[MUKCA_RIPPLE_ORDERS + 1];
        if (!guess_ripple(odds, s, j, u, along)) continue;
        for (int k = 0; k < ADDED; k++) {
            int best = 2;
            for (int o = 3; o <= MUKCA_RIPPLE_ORDERS; o++)
                if (odds[o] > odds[best]) best = o;
            if (!(odds[best] - log(s->all->classes * r->chain->n_joints) > least)) break;
            odds[best] = -HUGE_VAL;
            const mukca_status status =
                mukca_candidates_add_ripple(s->all, &s->m->pool, r, j, best, error);
            if (status != MUKCA_OK) return status;
        }
    }
    score_from(s, first);
    return MUKCA_OK;
}

mukca_status mukca_scan_run(mukca_scan *s, bool ripple, mukca_error *error)
{
    score_from(s, 0);
    residual_products(s->u, s);
    mukca_scan_faults(s);
    return ripple ? add_ripple(s, error) : MUKCA_OK;
}

bool mukca_scan_question(mukca_question *question, mukca_scan *s, mukca_pool *pool,
                         const int *index, int n)
{
    const mukca_recording *r = &s->m->recording;
    const int rows = r->n_samples * r->dim, pairs = r->n_pairs;
    int columns = 0, width = 0, squares = 0, at = 0;
    for (int i = 0; i < n; i++) columns += s->all->list[index[i]].terms;
    const int stride = ((columns + 7) | 8) & ~7, all = rows + pairs + s->n;
    mukca_item *item = MUKCA_TAKE(pool, mukca_item, n + 1);
    for (int i = 0; i < n; i++)
        squares += s->all->list[index[i]].terms * s->all->list[index[i]].terms;
    double *E = MUKCA_TAKE(pool, double, (size_t)all *(size_t)stride + 1),
           *g = MUKCA_TAKE(pool, double, stride + 1),
           *block = MUKCA_TAKE(pool, double, squares + 1);
    if (pool->failed) return false;
    batch b = {0};
    for (int i = 0; i < n; i++) {
        const mukca_candidate *h = &s->all->list[index[i]];
        item[i] = (mukca_item){.at = width + b.width,
                               .terms = h->terms,
                               .prior = mukca_candidate_mixture(h),
                               .log_prior = h->log_prior - MUKCA_SET_RATE,
                               .key = mukca_candidate_key(h),
                               .kin = mukca_candidate_kin(h),
                               .kinship = KINSHIP};
        put(s, &b, index[i]);
        const int next = i + 1 < n ? s->all->list[index[i + 1]].terms : LD;
        if (b.width + next <= LD) continue;
        project(s, &b);
        const double root = sqrt(s->precision);
        for (int k = 0; k < b.width; k++) g[width + k] = s->g[k];
        for (int e = 0; e < b.n; e++) {
            const int k = s->all->list[b.index[e]].terms;
            gram_of(block + at, s, b.at[e], k);
            at += k * k;
        }
        for (int row = 0; row < all; row++) {
            double *out = E + (size_t)row * (size_t)stride + width;
            const double *in = row < rows           ? s->W + row * LD
                               : row < rows + pairs ? s->along + (row - rows) * LD
                                                    : s->T + (row - rows - pairs) * LD,
                         by = row < rows           ? root
                              : row < rows + pairs ? sqrt(s->inverse[row - rows])
                                                   : 1;
            for (int k = 0; k < b.width; k++) out[k] = by * in[k];
        }
        width += b.width;
        b.n = b.width = 0;
    }
    *question = (mukca_question){.n_items = n,
                                 .n_columns = columns,
                                 .stride = stride,
                                 .n_rows = all,
                                 .n_projected = s->n,
                                 .item = item,
                                 .E = E,
                                 .g = g,
                                 .block = block,
                                 .residual = s->residual,
                                 .dof = s->dof};
    return true;
}

bool mukca_scan_orders(double *value, mukca_scan *s, int joint)
{
    const mukca_recording *r = &s->m->recording;
    mukca_candidate h = {.kind = MUKCA_CANDIDATE_EFFECT,
                         .joint = joint,
                         .placement = -1,
                         .effect = {.kind = MUKCA_EFFECT_GEAR_HARMONIC,
                                    .joint = joint,
                                    .placement = -1,
                                    .variant.order = 2}};
    if (!mukca_candidate_prepare(&h, &s->m->pool, r)) return false;
    mukca_candidates one = {.list = &h, .count = 1}, *all = s->all;
    s->all = &one;
    for (int o = 2; o <= MUKCA_RIPPLE_ORDERS; o++) {
        h.effect.variant.order = o;
        mukca_candidate_fill(&h, r);
        score_from(s, 0);
        value[o] = s->value[0];
    }
    s->all = all;
    return true;
}
