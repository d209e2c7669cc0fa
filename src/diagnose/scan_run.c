/* Scores of all candidates: those of the list, and the orders of periodic effects that promise. */
#include "diagnose/scan.h"

#include <math.h>
#include <string.h>

#include "base/clones.h"
#include "infer/given.h"
#include "math/dense.h"
#include "math/four.h"

enum {
    ADDED = 12,       /* orders of an effect at a joint in one scan, */
    ADDED_FRAMES = 8, /* and waves of frames of the arm */
    FAULTS = 40,      /* of a kind and shape that are scored: there are several for each sample */
    SHAPES = MUKCA_FAULT_GROWING + 1
};

/* Log odds below which an order is not listed. */
#define LEAST_ODDS (-5)

/* u[n_samples][dim]: products of the residual with columns that are not whitened.  False: no
 * memory. */
static bool residual_products(double *u, mukca_pool *pool, const mukca_scan *s)
{
    const mukca_recording *r = &s->m->recording;
    const mukca_linearisation *linear = &s->m->linear;
    const mukca_whitening *w = &s->normal->whitening;
    const int n = s->n, d = r->dim, ld = linear->stride;
    double *mean = MUKCA_TAKE(pool, double, n + 1), *white = MUKCA_TAKE(pool, double, s->n_rows);
    if (pool->failed) return false;
    memcpy(mean, s->z, sizeof *mean * (size_t)n);
    mukca_dense_backward(mean, 1, s->m->evidence.posterior.factor, n);
    for (int t = 0; t < n; t++) mean[t] *= s->prior[t];
    for (int i = 0; i < s->n_rows; i++) {
        const double *x = s->white + (size_t)i * (size_t)ld;
        white[i] = x[linear->y];
        for (int t = 0; t < n; t++) white[i] -= x[t] * mean[t];
        white[i] *= s->precision;
    }
    for (int p = 0; p < r->n_pairs; p++) {
        const double rest = s->link[p] * white[r->n_samples * d + p];
        for (int side = 0; side < 2; side++) {
            const int g = side ? r->pairs[p].b : r->pairs[p].a;
            const mukca_group *group = &r->groups[g];
            double x[6] = {0};
            for (int c = 0; c < 3; c++) x[c] = (side ? -1 : 1) * rest * linear->direction[p][c];
            mukca_whitening_solve(x, w, g, d);
            for (int i = group->start * d; i < (group->start + group->count) * d; i++)
                for (int c = 0; c < d; c++) white[i] += w->one[i * d + c] * x[c];
        }
    }
    mukca_whitening_transpose(u, white, 1, 1, w, &r->samples);
    return true;
}

/* ---- faults ---- */

/* Squared residual along the columns of a fault, per unit of them, for independent samples; u:
 * residual.  The geometry absorbs little of it. */
static double square_along(const mukca_scan *s, const mukca_candidate *h, const double *u)
{
    const mukca_recording *r = &s->m->recording;
    const mukca_group *group = &r->groups[h->fault.group];
    double along[3] = {0}, sum = 0, square = 0;
    for (int i = group->start; i < group->start + group->count; i++) {
        const double displacement = mukca_candidate_fault_share(h, r, r->order[i]);
        sum += displacement, square += displacement * displacement;
        for (int c = 0; c < 3; c++) along[c] += displacement * u[i * r->dim + c];
    }
    const double mean = group->socket >= 0 && group->count ? sum / group->count : 0;
    square -= mean * sum;
    for (int p = 0; p < r->n_pairs; p++) /* the socket's mean changes its distance from another */
        if (r->pairs[p].a == h->fault.group || r->pairs[p].b == h->fault.group)
            square += mean * s->link[p] * mean * s->link[p];
    return square > 1e-9 ? mukca_dot3(along, along) / square : 0;
}

/* Skip all faults but those of each kind and shape with the largest residuals along them. */
static bool choose_faults(unsigned char *skip, mukca_pool *pool, const mukca_scan *s,
                          const double *u)
{
    const mukca_candidates *all = s->all;
    double *square = MUKCA_TAKE(pool, double, all->count);
    if (!square) return false;
    for (int i = 0; i < all->count; i++) {
        const mukca_candidate *h = &all->list[i];
        skip[i] = mukca_candidate_is_fault(h);
        if (skip[i] && s->m->recording.keep[h->fault.first]) square[i] = square_along(s, h, u);
    }
    for (int shape = 0; shape < 2 * SHAPES; shape++)
        for (int k = 0; k < FAULTS; k++) {
            int best = -1;
            for (int i = 0; i < all->count; i++) {
                const mukca_candidate *h = &all->list[i];
                if (!skip[i] || !(square[i] > (best < 0 ? 0 : square[best]))) continue;
                if (SHAPES * (h->kind == MUKCA_CANDIDATE_MOTION) + (int)h->fault.shape == shape)
                    best = i;
            }
            if (best < 0) break;
            skip[best] = 0;
        }
    return true;
}

/* ---- orders: waves of a joint's angle ---- */

enum { AXES = 3 }; /* along or about which a wave displaces, at most */

/* Sine and cosine of one order at the angles of a joint. */
typedef struct {
    int n;
    double *sine, *cosine; /* [n] samples */
    double *first;         /* [2][n] those of order 1 */
    double *along[AXES];   /* [n] residual along each axis */
} waves;

/* Order 1 of a joint. */
static void start(waves *wave, const mukca_recording *r, int joint)
{
    const int n_joints = r->chain->n_joints, n = wave->n;
    for (int i = 0; i < n; i++) {
        const double q = r->q[r->order[i] * n_joints + joint];
        wave->first[i] = wave->sine[i] = sin(q);
        wave->first[n + i] = wave->cosine[i] = cos(q);
    }
}

/* The next order, by the angle addition formulas. */
MUKCA_CLONES static void advance(waves *wave)
{
    const int n = wave->n;
    const double *restrict s1 = wave->first, *restrict c1 = s1 + n;
    double *restrict sine = wave->sine, *restrict cosine = wave->cosine;
    for (int i = 0; i < n; i++) {
        const double s = sine[i], c = cosine[i];
        sine[i] = s * c1[i] + c * s1[i];
        cosine[i] = c * c1[i] - s * s1[i];
    }
}

/* Order of a periodic candidate of the kind of another one at its place, 0: it is none. */
static int order_of(const mukca_candidate *h, const mukca_candidate *like)
{
    if (h->kind != like->kind || h->joint != like->joint) return 0;
    if (h->kind == MUKCA_CANDIDATE_EFFECT)
        return h->effect.kind == like->effect.kind ? h->effect.variant.order : 0;
    return h->unlisted.function == like->unlisted.function &&
                   h->unlisted.place == like->unlisted.place &&
                   h->unlisted.slot == like->unlisted.slot
               ? (int)h->unlisted.measure
               : 0;
}

/* Residual u along the axes of a candidate, and products of its levers with each other, K. */
static int project_levers(double K[AXES * AXES], waves *wave, const mukca_scan *s,
                          const mukca_candidate *h, const double *u)
{
    const mukca_recording *r = &s->m->recording;
    const mukca_linearisation *linear = &s->m->linear;
    const int d = r->dim, n = r->chain->n_joints;
    const bool frame = h->kind == MUKCA_CANDIDATE_UNLISTED;
    const int axes = frame ? AXES : 1, step = frame ? linear->stride : 1;
    const double *lever = frame ? linear->columns + 6 * h->unlisted.slot +
                                      (h->unlisted.place == MUKCA_PLACE_TURN ? 3 : 0)
                                : linear->lever + h->joint * d;
    memset(K, 0, sizeof *K * AXES * AXES);
    for (int i = 0; i < wave->n; i++, lever += frame ? d * step : n * d) {
        const double level = s->normal->whitening.level[i], by = s->precision * level * level;
        for (int a = 0; a < axes; a++) {
            wave->along[a][i] = 0;
            for (int c = 0; c < d; c++) {
                wave->along[a][i] += lever[c * step + a] * u[i * d + c];
                for (int b = 0; b < axes; b++)
                    K[a * axes + b] += by * lever[c * step + a] * lever[c * step + b];
            }
        }
    }
    return axes;
}

/* Log odds of the orders of a periodic candidate that are not yet listed. */
typedef struct {
    mukca_candidate h;
    double *odds; /* [MUKCA_LAST_ORDER + 1] from 2 on */
} guess;

typedef struct {
    mukca_scan *scan;
    const double *u; /* residual */
    waves *wave;     /* of each worker */
    guess *list;
    int n;
} guesses;

/* The geometry absorbs little of a short wave: all have nearly the same information, and the
 * gradient is exact. */
static void weigh_orders(void *context, int index, int worker)
{
    const guesses *all = context;
    const mukca_scan *s = all->scan;
    const mukca_candidate *h = &all->list[index].h;
    const mukca_mixture prior = mukca_candidate_mixture(h);
    waves *wave = &all->wave[worker];
    double K[AXES * AXES], G[4 * AXES * AXES] = {0}, g[2 * AXES], *odds = all->list[index].odds;
    const int axes = project_levers(K, wave, s, h, all->u), terms = 2 * axes;
    for (int a = 0; a < axes; a++) /* a wave has half, its unit is as small: twice */
        for (int b = 0; b < axes; b++)
            G[a * terms + b] = G[(axes + a) * terms + axes + b] =
                K[a * axes + b] * fmax(1 - (double)s->n / s->dof, 0.1);
    const mukca_equations columns = {G, g, terms, s->dof, s->residual};
    start(wave, &s->m->recording, h->joint);
    for (int o = 2; o <= MUKCA_LAST_ORDER; o++) {
        advance(wave);
        for (int a = 0; a < axes; a++) {
            g[a] = dot4(wave->along[a], wave->sine, wave->n) / MUKCA_WAVE_UNIT;
            g[axes + a] = dot4(wave->along[a], wave->cosine, wave->n) / MUKCA_WAVE_UNIT;
        }
        odds[o] = mukca_candidates_order_prior(s->all, h, o) +
                  mukca_mixture_evidence(NULL, &columns, &prior, s->batch[worker].scratch);
    }
    for (int i = 0; i < s->all->count; i++) {
        const int order = order_of(&s->all->list[i], h);
        if (order > 1) odds[order] = -HUGE_VAL;
    }
}

/* Add the most promising orders of all guesses, at most `most`. */
static mukca_status add_best(mukca_scan *s, const guess *list, int n, int most, mukca_error *error)
{
    struct {
        double odds;
        int order;
        const guess *of;
    } best[ADDED];
    for (int k = 0; k < most; k++) best[k].odds = LEAST_ODDS;
    for (int i = 0; i < n; i++)
        for (;;) {
            const int order = 2 + mukca_set_largest(list[i].odds + 2, MUKCA_LAST_ORDER - 1);
            int least = 0;
            for (int k = 1; k < most; k++)
                if (best[k].odds < best[least].odds) least = k;
            if (!(list[i].odds[order] > best[least].odds)) break;
            best[least].odds = list[i].odds[order], best[least].order = order;
            best[least].of = &list[i];
            list[i].odds[order] = -HUGE_VAL;
        }
    for (int k = 0; k < most; k++)
        if (best[k].odds > LEAST_ODDS)
            MUKCA_TRY(mukca_candidates_add_order(s->all, best[k].of->h, best[k].order, error));
    return MUKCA_OK;
}

/* Append a candidate whose orders are to be weighed, if its joint's travel can show a wave. */
static void append(guesses *to, mukca_pool *pool, mukca_candidate h)
{
    const mukca_scan *s = to->scan;
    double travel[2];
    mukca_recording_travel(travel, &s->m->recording, h.joint);
    if (!s->all->survey.joint[h.joint].turns || travel[1] - travel[0] < MUKCA_WAVE_TRAVEL) return;
    to->list[to->n++] = (guess){h, MUKCA_TAKE(pool, double, MUKCA_LAST_ORDER + 1)};
}

/* Add the promising orders of periodic candidates. */
static mukca_status add_orders(mukca_scan *s, mukca_pool *pool, const double *u, mukca_error *error)
{
    double unit[] = {MUKCA_WAVE_UNIT, MUKCA_WAVE_UNIT};
    const mukca_candidates *all = s->all;
    mukca_workers *workers = s->m->recording.workers;
    const int first = all->count, N = s->m->recording.n_samples, n_joints = all->survey.n_joints,
              n_workers = mukca_workers_count(workers);
    guesses to = {.scan = s,
                  .u = u,
                  .wave = MUKCA_TAKE(pool, waves, n_workers),
                  .list = MUKCA_TAKE(pool, guess, all->count + MUKCA_EFFECT_COUNT * n_joints)};
    for (int w = 0; to.wave && w < n_workers; w++) {
        to.wave[w] = (waves){.n = N,
                             .sine = MUKCA_TAKE(pool, double, N),
                             .cosine = MUKCA_TAKE(pool, double, N),
                             .first = MUKCA_TAKE(pool, double, 2 * N)};
        for (int a = 0; a < AXES; a++) to.wave[w].along[a] = MUKCA_TAKE(pool, double, N);
    }
    for (int kind = 0; to.list && kind < MUKCA_EFFECT_COUNT; kind++)
        for (int j = 0; j < n_joints; j++) {
            mukca_candidate h = mukca_candidate_of(
                &(mukca_effect){.kind = (mukca_effect_kind)kind, .joint = j, .placement = -1});
            h.unit = unit;
            h.terms = 2;
            if (mukca_effect_has(kind, MUKCA_TRAIT_ORDERS) && all->enabled[kind])
                append(&to, pool, h);
        }
    const int effects = to.n;
    for (int i = 0; to.list && i < all->count; i++) {
        const mukca_candidate *h = &all->list[i];
        if (h->kind == MUKCA_CANDIDATE_UNLISTED && mukca_unlisted_site(h) == MUKCA_SITE_FRAME &&
            mukca_unlisted_functions[h->unlisted.function].shape == MUKCA_SHAPE_WAVE &&
            h->unlisted.measure == 1)
            append(&to, pool, *h);
    }
    if (pool->failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d samples", N);
    mukca_workers_run(workers, to.n, weigh_orders, &to);
    for (int i = 0; i < effects; i++) MUKCA_TRY(add_best(s, &to.list[i], 1, ADDED, error));
    MUKCA_TRY(add_best(s, to.list + effects, to.n - effects, ADDED_FRAMES, error));
    mukca_scan_score(s->value + first, s->information + first, s, all->list + first, NULL,
                     all->count - first);
    return MUKCA_OK;
}

mukca_status mukca_scan_run(mukca_scan *s, mukca_error *error)
{
    const mukca_recording *r = &s->m->recording;
    const mukca_candidates *all = s->all;
    mukca_pool pool = {0};
    double *u = MUKCA_TAKE(&pool, double, r->n_samples * r->dim);
    unsigned char *skip = MUKCA_TAKE(&pool, unsigned char, all->count);
    mukca_status status = MUKCA_OK;
    for (int i = 0; i < all->count; i++) s->value[i] = -HUGE_VAL, s->information[i] = 0;
    if (pool.failed || !residual_products(u, &pool, s) || !choose_faults(skip, &pool, s, u)) {
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for the scores of %d candidates",
                            all->count);
    } else {
        mukca_scan_score(s->value, s->information, s, all->list, skip, all->count);
        status = add_orders(s, &pool, u, error);
    }
    mukca_pool_free(&pool);
    return status;
}

bool mukca_scan_orders(double *value, mukca_scan *s, const mukca_effect *effect)
{
    const mukca_recording *r = &s->m->recording;
    double information = 0;
    mukca_candidate h = mukca_candidate_of(effect);
    h.effect.variant.order = 2;
    if (!mukca_candidate_prepare(&h, &s->m->pool, r)) return false;
    for (int o = 2; o <= MUKCA_LAST_ORDER; o++) {
        h.effect.variant.order = o;
        mukca_candidate_fill(&h, r);
        mukca_scan_score(&value[o], &information, s, &h, NULL, 1);
    }
    return true;
}
