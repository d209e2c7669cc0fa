/* Score every candidate cause against the present model. */
#include "diagnose/scan.h"

#include <math.h>
#include <string.h>

#include "diagnose/angle_noise.h"
#include "diagnose/correlation.h"
#include "diagnose/noise.h"
#include "diagnose/projector.h"
#include "diagnose/ripple_scan.h"
#include "diagnose/unlisted.h"

const mukca_candidate *mukca_scan_candidate(const mukca_scan *scan, int index)
{
    return index < scan->all->count ? &scan->all->list[index]
                                    : &scan->harmonic[index - scan->all->count];
}

/* Products of one score; NULL: no memory. */
static mukca_products *products_of(mukca_scan *scan, int rho, int index, int columns)
{
    mukca_products *x = &scan->products[rho][index];
    return mukca_products_reserve(x, &scan->pool, scan->projector.m, columns) ? x : NULL;
}

/* Add the best orders of ripple of a joint to the candidates. */
static void pick_harmonics(mukca_scan *scan, int j)
{
    mukca_regression *m = scan->projector.m; /* bases outlive the scan in accepted causes */
    const mukca_recording *r = &m->recording;
    const int n_joints = r->chain->n_joints;
    double value[MUKCA_RIPPLE_ORDERS + 1], travel[2];
    mukca_recording_travel(travel, r, j);
    if (!scan->all->survey.joint[j].turns || travel[1] - travel[0] < 1e-2) return;
    mukca_ripple_scan(value, &scan->projector, &scan->ripple, j);
    for (int order = 2; order <= MUKCA_RIPPLE_ORDERS; order++)
        value[order] += mukca_ripple_log_prior(order);
    for (int k = 0; k < MUKCA_RIPPLE_KEPT; k++) {
        int best = 2, known = 0, of_joint = 0;
        for (int order = 3; order <= MUKCA_RIPPLE_ORDERS; order++)
            if (value[order] > value[best]) best = order;
        for (int i = 0; i < scan->n_harmonic; i++) {
            const mukca_candidate *e = &scan->harmonic[i];
            known |= e->joint == j && e->effect.variant.order == best;
            of_joint += e->joint == j;
        }
        value[best] = -HUGE_VAL;
        if (known || of_joint == MUKCA_RIPPLE_MOST) continue;
        mukca_candidate *h = &scan->harmonic[scan->n_harmonic];
        *h = (mukca_candidate){.kind = MUKCA_CANDIDATE_EFFECT,
                               .joint = j,
                               .placement = -1,
                               .effect = {.kind = MUKCA_EFFECT_GEAR_HARMONIC,
                                          .joint = j,
                                          .placement = -1,
                                          .variant.order = best}};
        if (!mukca_candidate_prepare(h, &m->pool, r)) continue;
        h->log_prior = mukca_ripple_log_prior(best) - log(n_joints) - log(scan->all->classes);
        scan->n_harmonic++;
    }
}

/* Set the prior sigmas, 0 for cause `without`. */
static void leave_out(mukca_regression *m, int without)
{
    mukca_unknowns_prior(m->evidence.prior, &m->unknowns);
    if (without < 0) return;
    memset(m->evidence.prior + mukca_unknowns_column(&m->unknowns, without), 0,
           sizeof *m->evidence.prior * (size_t)m->unknowns.cause[without].candidate.terms);
}

/* Least log odds of a contender for the place of an accepted cause. */
#define LEAST_LOG_ODDS (-3.0F)

/* The same effect at the same joint, placement or socket. */
static bool same_effect(const mukca_candidate *a, const mukca_candidate *b)
{
    return mukca_candidate_class(a) == mukca_candidate_class(b) && a->joint == b->joint &&
           a->placement == b->placement && a->kind != MUKCA_CANDIDATE_OUTLIER;
}

static bool contends(const mukca_scan *scan, int index, const mukca_accepted *cause)
{
    const mukca_candidate *h = mukca_scan_candidate(scan, index), *own = &cause->candidate;
    if (own->kind == MUKCA_CANDIDATE_OUTLIER) return mukca_candidate_same(h, own);
    if (same_effect(h, own)) return true;
    for (int step = cause->step; step < scan->steps && step < MUKCA_SCAN_STEPS; step++)
        if (scan->history[step * scan->capacity + index] > LEAST_LOG_ODDS) return true;
    return false;
}

/* Is it a variant of an accepted elastic cause at the same joint: softening, bending along a link,
 * or an unknown payload?  Both are one cause. */
static bool is_same_spring(const mukca_candidate *h, const mukca_candidate *cause)
{
    const mukca_argument argument = h->simple.argument;
    return h->kind != MUKCA_CANDIDATE_UNLISTED_TILT && h->joint == cause->joint &&
           (argument == MUKCA_ARGUMENT_SOFTENING || argument == MUKCA_ARGUMENT_PAYLOAD ||
            argument == MUKCA_ARGUMENT_MOMENT) &&
           mukca_effect_has(mukca_candidate_class(cause), MUKCA_TRAIT_ELASTIC);
}

/* Is a candidate scored at the other AR(1) coefficients, too?  Scores hardly depend on them: only
 * those near the best are averaged. */
static bool worth_averaging(double log_bayes, double log_prior, double most)
{
    return log_bayes + log_prior > -4.0 || log_bayes > fmax(0.25 * most, 4.0);
}

/* Noise and evidence at an AR(1) coefficient.  Sets the priors without the cause. */
static double weigh_rho(double *sigma, mukca_regression *m, int rho, int without)
{
    const mukca_unknowns *u = &m->unknowns;
    const mukca_left_out out = {.column = without < 0 ? 0 : mukca_unknowns_column(u, without),
                                .count = without < 0 ? 0 : u->cause[without].candidate.terms,
                                .from = u->n_geometry};
    mukca_evidence *evidence = &m->evidence;
    double value;
    mukca_unknowns_prior(evidence->prior, u);
    *sigma = mukca_noise_choose(evidence, mukca_regression_collect(m, rho), &out, u->sigma, &value);
    leave_out(m, without);
    /* noise is the residual of the full model, without the missing cause's contribution */
    if (without < 0 || !(*sigma > 1.15 * u->sigma)) return value;
    *sigma = 1.15 * u->sigma;
    return mukca_evidence_evaluate(evidence, &evidence->normal[rho], *sigma, NULL);
}

/* The same at each AR(1) coefficient that may matter, NaN at the others; returns the index of the
 * best. */
static int weigh_rhos(mukca_regression *m, double *sigma, double *value, int without)
{
    const int own = mukca_evidence_index(m->unknowns.rho);
    int best = own;
    value[own] = weigh_rho(&sigma[own], m, own, without);
    for (int i = 0; i < MUKCA_RHOS; i++) {
        if (i == own) continue;
        value[i] = mukca_noise_contends(&m->evidence, i, value[best], 0)
                       ? weigh_rho(&sigma[i], m, i, without)
                       : (double)NAN;
        if (value[i] > value[best]) best = i;
    }
    return best;
}

/* Cost of scoring a fault by its columns, in rows of the projector. */
enum { ROWS_OF_A_FAULT = 4 };

static int count_faults(const mukca_scan *scan)
{
    int n = 0;
    for (int k = 0; k < scan->n_scores; k++)
        n += scan->wanted[k] && mukca_candidate_is_fault(mukca_scan_candidate(scan, k));
    return n;
}

/* Score the wanted candidates at the projector's AR(1) coefficient; `pick`: add ripple orders. */
static void score_all(mukca_scan *scan, int rho, bool pick)
{
    mukca_projector *p = &scan->projector;
    const mukca_regression *m = p->m;
    int n = 0;
    for (int j = 0; j < m->recording.chain->n_joints && pick; j++) pick_harmonics(scan, j);
    scan->n_scores = scan->all->count + scan->n_harmonic;
    if (count_faults(scan) > p->rows / ROWS_OF_A_FAULT) mukca_projector_rows(p);
    const bool by_rows = p->have_rows;
    for (int j = -1; j < m->recording.chain->n_joints; j++) /* functions of one joint together */
        for (int k = 0; k < scan->n_scores; k++) {
            if (!scan->wanted[k]) continue;
            const mukca_candidate *h = mukca_scan_candidate(scan, k);
            if (j >= 0 && h->joint != j) continue;
            if (mukca_candidate_turns_joint(h) != (j >= 0)) continue;
            if (mukca_candidate_is_fault(h)) {
                const bool kept = m->recording.keep[h->fault.first];
                if (!kept) scan->value[k] = -HUGE_VAL;
                if (kept && by_rows)
                    scan->value[k] = mukca_projector_fault(p, h, &scan->information[k]);
                if (!kept || by_rows) continue;
            }
            mukca_products *x = products_of(scan, rho, k, h->terms);
            if (!x) return;
            scan->item[n] = (mukca_product_item){h, j, x};
            scan->scored[n++] = (mukca_scored){x, h, &scan->value[k], &scan->information[k]};
        }
    mukca_products_update(scan->item, n, m, p->normal, &p->scratch);
    mukca_projector_score(p, scan->scored, n);
}

/* Prepare a candidate that was not needed before.  False: no memory. */
static bool prepare(mukca_candidate *h, mukca_regression *m)
{
    return h->unit || mukca_candidate_prepare(h, &m->pool, &m->recording);
}

/* Is an unlisted candidate a rival of that cause (NULL: none is left out)?  A moved socket may be a
 * joint slip at that very sample, which the grid of listed slips may miss. */
static bool is_rival(mukca_scan *scan, int index, const mukca_candidate *cause, mukca_regression *m)
{
    mukca_candidate *h = &scan->all->list[index];
    if (mukca_unlisted_at_sample(h)) {
        if (!cause || cause->kind != MUKCA_CANDIDATE_STEP) return false;
        if (h->simple.row != cause->fault.first) {
            h->simple.row = cause->fault.first;
            h->unit = NULL;
            for (int i = 0; i < MUKCA_RHOS; i++) scan->products[i][index].version = 0;
        }
    }
    return !(cause && is_same_spring(h, cause)) && prepare(h, m);
}

/* Store the odds of a run against the whole model; orders of ripple found later have none. */
static void store_odds(mukca_scan *scan)
{
    const int step = scan->steps < MUKCA_SCAN_STEPS ? scan->steps : MUKCA_SCAN_STEPS - 1;
    float *odds = scan->history + step * scan->capacity;
    for (int k = 0; k < scan->capacity; k++)
        odds[k] = k < scan->n_scores ? (float)scan->score[k].log_odds : -HUGE_VALF;
    scan->steps++;
}

void mukca_scan_run(mukca_scan *scan, mukca_regression *m, int without, mukca_scan_extent extent)
{
    double value[MUKCA_RHOS], sigma[MUKCA_RHOS];
    const bool ripple = extent == MUKCA_SCAN_ALL || extent == MUKCA_SCAN_RIPPLE;
    const int best = scan->rho = weigh_rhos(m, sigma, value, without);
    scan->sigma = sigma[best];

    double first = -HUGE_VAL; /* evidence of the rhos averaged so far */
    memset(scan->wanted, 1, (size_t)scan->capacity);
    scan->n_scores = scan->all->count + scan->n_harmonic;
    for (int k = 0; k < scan->n_scores; k++)
        if (mukca_candidate_is_unlisted(mukca_scan_candidate(scan, k)))
            scan->wanted[k] =
                extent >= MUKCA_SCAN_RIVALS &&
                is_rival(scan, k, without < 0 ? NULL : &m->unknowns.cause[without].candidate, m);
        else if (extent == MUKCA_SCAN_RIPPLE || extent == MUKCA_SCAN_UNLISTED)
            scan->wanted[k] = 0;
        else if (extent >= MUKCA_SCAN_CONTENDERS)
            scan->wanted[k] = contends(scan, k, &m->unknowns.cause[without]);
    if (extent != MUKCA_SCAN_RIPPLE) scan->most = -HUGE_VAL;
    for (int k = 0; k < scan->n_scores && extent != MUKCA_SCAN_RIPPLE; k++)
        scan->score[k] = (mukca_score){.index = k, .log_bayes = -HUGE_VAL, .log_odds = -HUGE_VAL};
    for (int i = 0; i < MUKCA_RHOS; i++) {
        const int which = i == 0 ? best : i <= best ? i - 1 : i; /* the best one comes first */
        if (i && isnan(value[which]) &&
            mukca_noise_contends(&m->evidence, which, value[best], scan->most))
            value[which] = weigh_rho(&sigma[which], m, which, without);
        if (i && !mukca_noise_counts(value[best] - value[which], scan->most)) continue;
        mukca_projector_aim(&scan->projector, &m->evidence.normal[which], sigma[which]);
        score_all(scan, which, i == 0 && scan->all->harmonics && ripple);
        /* Running average over rho, weighted by the evidence of the model scanned against. */
        const double hi = fmax(first, value[which]);
        const double old_share = exp(first - hi) / (exp(first - hi) + exp(value[which] - hi));
        for (int k = 0; k < scan->n_scores; k++) {
            mukca_score *score = &scan->score[k];
            if (!scan->wanted[k]) continue;
            if (i == 0) {
                *score = (mukca_score){
                    .index = k, .log_bayes = scan->value[k], .information = scan->information[k]};
                scan->most = fmax(scan->most, scan->value[k]);
            } else if (scan->value[k] > -HUGE_VAL) {
                const double a = score->log_bayes + log(fmax(old_share, 1e-300));
                const double b = scan->value[k] + log(fmax(1 - old_share, 1e-300));
                score->log_bayes = fmax(a, b) + log1p(exp(-fabs(a - b)));
            }
        }
        first = hi + log(exp(first - hi) + exp(value[which] - hi));
        for (int k = 0; i == 0 && k < scan->n_scores; k++)
            scan->wanted[k] = scan->wanted[k] &&
                              worth_averaging(scan->value[k],
                                              mukca_scan_candidate(scan, k)->log_prior, scan->most);
    }
    for (int k = 0; k < scan->n_scores; k++) {
        mukca_score *score = &scan->score[k];
        score->log_odds = score->log_bayes + mukca_scan_candidate(scan, k)->log_prior;
    }
    if (without < 0 && extent != MUKCA_SCAN_UNLISTED) store_odds(scan);
}

void mukca_scan_weigh(mukca_scan *scan, mukca_regression *m, int without)
{
    double value[MUKCA_RHOS], sigma[MUKCA_RHOS];
    scan->rho = weigh_rhos(m, sigma, value, without);
    scan->sigma = sigma[scan->rho];
}

const float *mukca_scan_last_odds(const mukca_scan *scan)
{
    const int step = (scan->steps < MUKCA_SCAN_STEPS ? scan->steps : MUKCA_SCAN_STEPS) - 1;
    return scan->history + step * scan->capacity;
}

int mukca_scan_repeat(mukca_scan *scan, int steps)
{
    const int from = scan->steps;
    if (from + steps > MUKCA_SCAN_STEPS) return 0;
    memcpy(scan->history + from * scan->capacity, scan->history,
           sizeof *scan->history * (size_t)(steps * scan->capacity));
    scan->steps += steps;
    return from;
}

/* Restore the projector's state of the last run. */
static mukca_projector *restore_projector(mukca_scan *scan, mukca_regression *m, int without)
{
    leave_out(m, without);
    mukca_regression_collect(m, scan->rho);
    mukca_projector_aim(&scan->projector, &m->evidence.normal[scan->rho], scan->sigma);
    return &scan->projector;
}

double mukca_scan_correlation(mukca_scan *scan, mukca_regression *m, int without,
                              const mukca_candidate *a, const mukca_candidate *b)
{
    return mukca_correlation_canonical(restore_projector(scan, m, without), a, b);
}

double mukca_scan_noise_gain(mukca_scan *scan, mukca_regression *m, int without,
                             const mukca_candidate *candidate)
{
    const mukca_recording *r = &m->recording;
    if (!candidate->basis || r->groups[r->n_groups - 1].socket < 0) return 0;
    return mukca_angle_noise_gain(restore_projector(scan, m, without), candidate);
}

mukca_status mukca_scan_create(mukca_scan *scan, mukca_candidates *all, mukca_regression *m,
                               mukca_error *error)
{
    const int harmonics = m->recording.chain->n_joints * MUKCA_RIPPLE_MOST,
              most = all->count + harmonics;
    memset(scan, 0, sizeof *scan);
    scan->all = all;
    scan->capacity = most;
    scan->harmonic = MUKCA_TAKE(&scan->pool, mukca_candidate, harmonics);
    scan->score = MUKCA_TAKE(&scan->pool, mukca_score, most);
    scan->history = MUKCA_TAKE(&scan->pool, float, (size_t)most *MUKCA_SCAN_STEPS);
    scan->wanted = MUKCA_TAKE(&scan->pool, unsigned char, most);
    scan->value = MUKCA_TAKE(&scan->pool, double, most);
    scan->information = MUKCA_TAKE(&scan->pool, double, most);
    scan->item = MUKCA_TAKE(&scan->pool, mukca_product_item, most);
    scan->scored = MUKCA_TAKE(&scan->pool, mukca_scored, most);
    for (int i = 0; i < MUKCA_RHOS; i++)
        scan->products[i] = MUKCA_TAKE(&scan->pool, mukca_products, most);
    mukca_projector_create(&scan->projector, &scan->pool, m);
    mukca_products_create(&scan->ripple, &scan->pool, m, 2 * MUKCA_RIPPLE_PROMISING, 2);
    if (!scan->pool.failed) return MUKCA_OK;
    mukca_scan_free(scan);
    return mukca_fail(error, MUKCA_MEMORY, "out of memory for the scan of %d candidates",
                      all->count);
}

void mukca_scan_free(mukca_scan *scan)
{
    mukca_pool_free(&scan->pool);
    memset(scan, 0, sizeof *scan);
}
