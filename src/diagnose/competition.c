/* The competition of all candidate causes. */
#include "diagnose/competition.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnose/screening.h"

/* Log posterior odds that the first cause and later ones need. */
#define FIRST_THRESHOLD 3.0
#define LATER_THRESHOLD 4.0
enum { MOST_CAUSES = 10, MOST_SPIKES = 12 };

static int by_odds(const void *a, const void *b)
{
    const gap_candidate *x = a, *y = b;
    return (x->log_odds < y->log_odds) - (x->log_odds > y->log_odds);
}

static gap_candidate key_of(const gap_hypothesis *h)
{
    gap_candidate c = {gap_hypothesis_class(h), h->effect.joint, -1, -HUGE_VAL, -1};
    if (h->kind == GAP_SPIKE)
        c.place = 8 * h->row + (h->last - h->row) % 8;
    else if (h->kind == GAP_STEP || h->kind == GAP_CREEP)
        c.place = h->group;
    else if (c.class == MUKCA_EFFECT_ZERO_JUMP || c.class == MUKCA_EFFECT_BALL_SHIFT ||
             c.class == MUKCA_EFFECT_SOCKET_DISTANCE)
        c.place = h->effect.placement;
    return c;
}

static bool same_key(const gap_candidate *a, const gap_candidate *b)
{
    return a->class == b->class && a->joint == b->joint && a->place == b->place;
}

void gap_compete_rank(gap_contest *contest)
{
    const gap_scan *scan = contest->scan;
    contest->n_table = 0;
    for (int i = 0; i < scan->n_scores; i++) {
        const gap_score *score = &scan->score[i];
        if (!(score->log_odds > -HUGE_VAL)) continue;
        gap_candidate key = key_of(gap_scan_hypothesis(scan, i));
        int at = key.class == GAP_CLASS_OUTLIER ? -1 : contest->n_table - 1;
        while (at >= 0 && !same_key(&contest->table[at], &key)) at--;
        if (at < 0) {
            at = contest->n_table++;
            contest->table[at] = key;
        }
        gap_candidate *c = &contest->table[at];
        if (c->best < 0 || score->log_odds > scan->score[c->best].log_odds) c->best = i;
        const double hi = fmax(c->log_odds, score->log_odds),
                     lo = fmin(c->log_odds, score->log_odds);
        c->log_odds = lo > -HUGE_VAL ? hi + log1p(exp(lo - hi)) : hi;
    }
    qsort(contest->table, (size_t)contest->n_table, sizeof *contest->table, by_odds);
}

/* Something that an accepted unknown function explains already: no function of the same argument
 * may be named after it.  What was accepted before (and is now left out) may come back. */
static bool shadowed(const gap_contest *contest, const gap_candidate *c, int without)
{
    const gap_model *m = contest->m;
    if (without >= 0) {
        const gap_candidate own = key_of(&m->cause[without].hypothesis);
        if (same_key(&own, c)) return false;
    }
    for (int i = 0; i < m->n_causes; i++) {
        const gap_hypothesis *h = &m->cause[i].hypothesis;
        if (i == without || gap_hypothesis_class(h) != GAP_CLASS_UNKNOWN ||
            h->effect.joint != c->joint)
            continue;
        if (c->class == GAP_CLASS_UNKNOWN) return true;
        if (h->driver == GAP_TIME) {
            if (c->class == MUKCA_EFFECT_JOINT_DRIFT) return true;
        } else if (h->driver != h->effect.joint) {
            if (c->class == MUKCA_EFFECT_JOINT_COUPLING) return true;
        } else if (c->class == MUKCA_EFFECT_GEAR_HARMONIC ||
                   c->class == MUKCA_EFFECT_ENCODER_ECCENTRICITY ||
                   c->class == MUKCA_EFFECT_JOINT_SCALE) {
            return true;
        }
    }
    return false;
}

bool gap_compete_taken(const gap_contest *contest, const gap_candidate *c, int except)
{
    const gap_model *m = contest->m;
    const gap_hypothesis *best = gap_scan_hypothesis(contest->scan, c->best);
    for (int i = 0; i < m->n_causes; i++) {
        const gap_hypothesis *h = &m->cause[i].hypothesis;
        const gap_candidate key = key_of(h);
        if (i != except && same_key(&key, c) && h->kind == best->kind && h->row == best->row &&
            h->driver == best->driver && h->effect.variant == best->effect.variant)
            return true;
    }
    return false;
}

static const gap_candidate *leader(const gap_contest *contest, int without)
{
    for (int i = 0; i < contest->n_table; i++) {
        const gap_candidate *c = &contest->table[i];
        if (!shadowed(contest, c, without) && !gap_compete_taken(contest, c, without)) return c;
    }
    return NULL;
}

static int spikes(const gap_model *m)
{
    int n = 0;
    for (int c = 0; c < m->n_causes; c++) n += m->cause[c].hypothesis.kind == GAP_SPIKE;
    return n;
}

static bool watch(const gap_contest *contest, const char *doing, mukca_error *error)
{
    const mukca_diagnose_options *o = contest->options;
    const double share = 0.1 + 0.6 * contest->m->n_causes / (MOST_CAUSES / 2.0);
    if (!o->progress || o->progress(o->progress_context, fmin(share, 0.7), doing)) return true;
    mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
    return false;
}

static bool add(gap_contest *contest, const gap_hypothesis *h)
{
    if (!gap_model_add(contest->m, h)) return false;
    contest->m->cause[contest->m->n_causes - 1].step = contest->scan->steps - 1;
    return true;
}

/* Accept a single bad row, and with it all others that are as plain. */
static bool add_spikes(gap_contest *contest, double least)
{
    gap_model *m = contest->m;
    const int before = m->n_causes;
    for (int i = 0; i < contest->n_table && spikes(m) < MOST_SPIKES; i++) {
        const gap_candidate *c = &contest->table[i];
        if (c->log_odds < least) break;
        if (c->class != GAP_CLASS_OUTLIER) continue;
        const gap_hypothesis *h = gap_scan_hypothesis(contest->scan, c->best);
        bool taken = false;
        for (int k = 0; k < m->n_causes; k++) {
            const gap_hypothesis *other = &m->cause[k].hypothesis;
            taken |= other->kind == GAP_SPIKE && other->group == h->group &&
                     h->row <= other->last && other->row <= h->last;
        }
        if (!taken) add(contest, h);
    }
    return m->n_causes > before;
}

static mukca_status forward(gap_contest *contest, mukca_error *error)
{
    gap_model *m = contest->m;
    gap_scan_extent extent = GAP_SCAN_ALL;
    while (m->n_causes - spikes(m) < MOST_CAUSES && spikes(m) < MOST_SPIKES) {
        if (!watch(contest, "looking for causes", error)) return MUKCA_INTERRUPTED;
        gap_scan_run(contest->scan, m, -1, extent);
        gap_compete_rank(contest);
        if (!contest->n_first) {
            contest->n_first = contest->n_table;
            memcpy(contest->first, contest->table,
                   sizeof *contest->first * (size_t)contest->n_table);
            memcpy(contest->first_score, contest->scan->score,
                   sizeof *contest->first_score * (size_t)contest->scan->n_scores);
        }
        const gap_candidate *top = leader(contest, -1);
        const double threshold = m->n_causes ? LATER_THRESHOLD : FIRST_THRESHOLD;
        if (!top || top->log_odds < threshold) {
            if (extent != GAP_SCAN_ALL) { /* before giving up: all orders of ripple once more */
                extent = GAP_SCAN_ALL;
                continue;
            }
            if (!gap_reinstate(contest->diagnosis, m)) return MUKCA_OK;
        } else if (top->class == GAP_CLASS_OUTLIER) {
            if (!add_spikes(contest, fmax(threshold, 0.5 * top->log_odds))) return MUKCA_OK;
        } else if (!add(contest, gap_scan_hypothesis(contest->scan, top->best))) {
            return MUKCA_OK;
        }
        extent = GAP_SCAN_LISTED;
        gap_model_fit(m, 3, GAP_FREE);
    }
    return MUKCA_OK;
}

/* Take each cause out, look who fills the hole best, and swap or drop. */
static mukca_status settle(gap_contest *contest, mukca_error *error)
{
    gap_model *m = contest->m;
    for (int round = 0; round < 2; round++) {
        bool changed = false;
        for (int c = 0; c < m->n_causes; c++) {
            if (!watch(contest, "testing each cause again", error)) return MUKCA_INTERRUPTED;
            gap_scan_run(contest->scan, m, c, GAP_SCAN_CONTENDERS);
            gap_compete_rank(contest);
            const gap_candidate *top = leader(contest, c);
            if (!top || top->log_odds < FIRST_THRESHOLD) {
                gap_model_drop(m, c--);
                gap_model_fit(m, 3, GAP_FREE);
                changed = true;
                continue;
            }
            const gap_hypothesis *best = gap_scan_hypothesis(contest->scan, top->best);
            const gap_hypothesis *now = &m->cause[c].hypothesis;
            const gap_candidate key = key_of(now);
            if (now->kind == GAP_SPIKE || round > 0 ||
                (same_key(&key, top) && best->effect.variant == now->effect.variant &&
                 best->row == now->row && best->kind == now->kind))
                continue;
            const int last = m->n_causes, step = m->cause[c].step;
            if (!add(contest, best)) continue;
            m->cause[last].step = step;
            m->cause[c] = m->cause[last];
            m->n_causes = last;
            gap_model_fit(m, 3, GAP_FREE);
            changed = true;
        }
        if (!changed) break;
    }
    return MUKCA_OK;
}

mukca_status gap_compete(gap_contest *contest, mukca_error *error)
{
    mukca_status status = forward(contest, error);
    if (status == MUKCA_OK) status = settle(contest, error);
    return status;
}
