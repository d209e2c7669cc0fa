/* The competition of all candidate causes. */
#include "diagnose/competition.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Log posterior odds that the first cause and later ones need: 20 to 1, and 55 to 1 since later
 * ones are tried many times. */
#define FIRST_THRESHOLD 3.0
#define LATER_THRESHOLD 4.0
enum { MOST_CAUSES = 10, MOST_OUTLIERS = 12 };

static int by_odds(const void *a, const void *b)
{
    const mukca_contender *x = a, *y = b;
    return (x->log_odds < y->log_odds) - (x->log_odds > y->log_odds);
}

static mukca_contender key_of(const mukca_candidate *h)
{
    mukca_contender c = {.class = mukca_candidate_class(h),
                         .joint = h->joint,
                         .place = -1,
                         .log_odds = -HUGE_VAL,
                         .best = -1};
    if (h->kind == MUKCA_CANDIDATE_OUTLIER)
        c.place = 8 * h->fault.first + (h->fault.last - h->fault.first) % 8;
    else if (mukca_candidate_is_fault(h))
        c.place = h->fault.group;
    else if (mukca_effect_has(c.class, MUKCA_TRAIT_PER_PLACEMENT))
        c.place = h->placement;
    return c;
}

static bool same_key(const mukca_contender *a, const mukca_contender *b)
{
    return a->class == b->class && a->joint == b->joint && a->place == b->place;
}

void mukca_competition_rank(mukca_competition *contest)
{
    const mukca_scan *scan = contest->scan;
    contest->n_table = 0;
    for (int i = 0; i < scan->n_scores; i++) {
        const mukca_score *score = &scan->score[i];
        if (!(score->log_odds > -HUGE_VAL)) continue;
        mukca_contender key = key_of(mukca_scan_candidate(scan, i));
        int at = key.class == MUKCA_CLASS_OUTLIER ? -1 : contest->n_table - 1;
        while (at >= 0 && !same_key(&contest->table[at], &key)) at--;
        if (at < 0) {
            at = contest->n_table++;
            contest->table[at] = key;
        }
        mukca_contender *c = &contest->table[at];
        if (c->best < 0 || score->log_odds > scan->score[c->best].log_odds) c->best = i;
        const double hi = fmax(c->log_odds, score->log_odds),
                     lo = fmin(c->log_odds, score->log_odds);
        c->log_odds = lo > -HUGE_VAL ? hi + log1p(exp(lo - hi)) : hi;
    }
    qsort(contest->table, (size_t)contest->n_table, sizeof *contest->table, by_odds);
}

/* Something that an accepted unknown function explains already: no function of the same argument
 * may be named after it.  What was accepted before (and is now left out) may come back. */
static bool shadowed(const mukca_competition *contest, const mukca_contender *c, int without)
{
    const mukca_regression *m = contest->m;
    if (without >= 0) {
        const mukca_contender own = key_of(&m->unknowns.cause[without].candidate);
        if (same_key(&own, c)) return false;
    }
    for (int i = 0; i < m->unknowns.n_causes; i++) {
        const mukca_candidate *h = &m->unknowns.cause[i].candidate;
        if (i == without || mukca_candidate_class(h) != MUKCA_CLASS_UNKNOWN || h->joint != c->joint)
            continue;
        if (c->class == MUKCA_CLASS_UNKNOWN) return true;
        const bool other =
            h->kind == MUKCA_CANDIDATE_OTHER_ANGLE || h->kind == MUKCA_CANDIDATE_ANGLE_PRODUCT;
        if (mukca_effect_has(c->class, other ? MUKCA_TRAIT_OTHER_ANGLE
                                       : h->kind == MUKCA_CANDIDATE_OWN_ANGLE
                                           ? MUKCA_TRAIT_OWN_ANGLE
                                           : MUKCA_TRAIT_OF_TIME))
            return true;
    }
    return false;
}

bool mukca_competition_taken(const mukca_competition *contest, const mukca_contender *c, int except)
{
    const mukca_regression *m = contest->m;
    const mukca_candidate *best = mukca_scan_candidate(contest->scan, c->best);
    for (int i = 0; i < m->unknowns.n_causes; i++) {
        if (i != except && mukca_candidate_same(&m->unknowns.cause[i].candidate, best)) return true;
    }
    return false;
}

static const mukca_contender *leader(const mukca_competition *contest, int without)
{
    for (int i = 0; i < contest->n_table; i++) {
        const mukca_contender *c = &contest->table[i];
        if (!shadowed(contest, c, without) && !mukca_competition_taken(contest, c, without))
            return c;
    }
    return NULL;
}

static int outliers(const mukca_regression *m)
{
    int n = 0;
    for (int c = 0; c < m->unknowns.n_causes; c++)
        n += m->unknowns.cause[c].candidate.kind == MUKCA_CANDIDATE_OUTLIER;
    return n;
}

static bool watch(const mukca_competition *contest, const char *doing, mukca_error *error)
{
    const mukca_diagnose_options *o = contest->options;
    const double share = 0.1 + 0.6 * contest->m->unknowns.n_causes / (MOST_CAUSES / 2.0);
    if (!o->progress || o->progress(o->progress_context, fmin(share, 0.7), doing)) return true;
    mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
    return false;
}

static bool add(mukca_competition *contest, const mukca_candidate *h)
{
    if (!mukca_unknowns_add(&contest->m->unknowns, h)) return false;
    contest->m->unknowns.cause[contest->m->unknowns.n_causes - 1].step = contest->scan->steps - 1;
    return true;
}

/* Accept a single bad row, and with it all others that are as plain. */
static bool add_outliers(mukca_competition *contest, double least)
{
    mukca_regression *m = contest->m;
    const int before = m->unknowns.n_causes;
    for (int i = 0; i < contest->n_table && outliers(m) < MOST_OUTLIERS; i++) {
        const mukca_contender *c = &contest->table[i];
        if (c->log_odds < least) break;
        if (c->class != MUKCA_CLASS_OUTLIER) continue;
        const mukca_candidate *h = mukca_scan_candidate(contest->scan, c->best);
        bool taken = false;
        for (int k = 0; k < m->unknowns.n_causes; k++) {
            const mukca_candidate *other = &m->unknowns.cause[k].candidate;
            taken |= other->kind == MUKCA_CANDIDATE_OUTLIER &&
                     other->fault.group == h->fault.group && h->fault.first <= other->fault.last &&
                     other->fault.first <= h->fault.last;
        }
        if (!taken) add(contest, h);
    }
    return m->unknowns.n_causes > before;
}

static mukca_status forward(mukca_competition *contest, mukca_error *error)
{
    mukca_regression *m = contest->m;
    mukca_scan_extent extent = MUKCA_SCAN_ALL;
    while (m->unknowns.n_causes - outliers(m) < MOST_CAUSES && outliers(m) < MOST_OUTLIERS) {
        if (!watch(contest, "looking for causes", error)) return MUKCA_INTERRUPTED;
        mukca_scan_run(contest->scan, m, -1, extent);
        mukca_competition_rank(contest);
        if (!contest->n_first) {
            contest->n_first = contest->n_table;
            memcpy(contest->first, contest->table,
                   sizeof *contest->first * (size_t)contest->n_table);
            memcpy(contest->first_score, contest->scan->score,
                   sizeof *contest->first_score * (size_t)contest->scan->n_scores);
        }
        const mukca_contender *top = leader(contest, -1);
        const double threshold = m->unknowns.n_causes ? LATER_THRESHOLD : FIRST_THRESHOLD;
        if (!top || top->log_odds < threshold) {
            if (extent != MUKCA_SCAN_ALL) { /* before giving up: all orders of ripple once more */
                extent = MUKCA_SCAN_ALL;
                continue;
            }
            if (!mukca_screening_reinstate(contest->faults, m)) return MUKCA_OK;
        } else if (top->class == MUKCA_CLASS_OUTLIER) {
            if (!add_outliers(contest, fmax(threshold, 0.5 * top->log_odds))) return MUKCA_OK;
        } else if (!add(contest, mukca_scan_candidate(contest->scan, top->best))) {
            return MUKCA_OK;
        }
        extent = MUKCA_SCAN_LISTED;
        mukca_regression_fit(m, 3, MUKCA_FIT_ALL);
    }
    return MUKCA_OK;
}

/* Would the verdict be the same?  It does not name the other joint of an unknown function. */
static bool says_the_same(const mukca_candidate *a, const mukca_candidate *b)
{
    const bool other =
        a->kind == MUKCA_CANDIDATE_OTHER_ANGLE || a->kind == MUKCA_CANDIDATE_ANGLE_PRODUCT;
    return mukca_candidate_same(a, b) || (other && a->kind == b->kind && a->joint == b->joint);
}

/* Take each cause out, look who fills the hole best, and swap or drop. */
static mukca_status settle(mukca_competition *contest, mukca_error *error)
{
    mukca_regression *m = contest->m;
    for (int round = 0; round < 2; round++) {
        bool changed = false;
        for (int c = 0; c < m->unknowns.n_causes; c++) {
            if (!watch(contest, "testing each cause again", error)) return MUKCA_INTERRUPTED;
            mukca_scan_run(contest->scan, m, c, MUKCA_SCAN_CONTENDERS);
            mukca_competition_rank(contest);
            const mukca_contender *top = leader(contest, c);
            if (!top || top->log_odds < FIRST_THRESHOLD) {
                mukca_unknowns_drop(&m->unknowns, c--);
                mukca_regression_fit(m, 3, MUKCA_FIT_ALL);
                changed = true;
                continue;
            }
            const mukca_candidate *best = mukca_scan_candidate(contest->scan, top->best);
            const mukca_candidate *now = &m->unknowns.cause[c].candidate;
            if (now->kind == MUKCA_CANDIDATE_OUTLIER || round > 0 || says_the_same(best, now))
                continue;
            const int last = m->unknowns.n_causes, step = m->unknowns.cause[c].step;
            if (!add(contest, best)) continue;
            m->unknowns.cause[last].step = step;
            m->unknowns.cause[c] = m->unknowns.cause[last];
            m->unknowns.n_causes = last;
            mukca_regression_fit(m, 3, MUKCA_FIT_ALL);
            changed = true;
        }
        if (!changed) break;
    }
    return MUKCA_OK;
}

mukca_status mukca_competition_run(mukca_competition *contest, mukca_error *error)
{
    mukca_pool *pool = &contest->m->pool;
    const int most = contest->scan->capacity;
    contest->table = MUKCA_TAKE(pool, mukca_contender, most);
    contest->first = MUKCA_TAKE(pool, mukca_contender, most);
    contest->first_score = MUKCA_TAKE(pool, mukca_score, most);
    if (pool->failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the competition of causes");
    mukca_status status = forward(contest, error);
    if (status == MUKCA_OK) status = settle(contest, error);
    return status;
}
