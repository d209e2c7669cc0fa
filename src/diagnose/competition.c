/* Competition of all candidate causes. */
#include "diagnose/competition.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Log posterior odds for acceptance: 20 to 1 for the first cause, 55 to 1 for later ones, which are
 * tested many times. */
#define FIRST_THRESHOLD 3.0
#define LATER_THRESHOLD 4.0
/* Preference for a named candidate over an unknown function, log odds (20 to 1). */
#define PREFERENCE 3.0
/* Log odds of a lead beyond which a cause is not tested again in the same search. */
#define SAFE_LEAD 15.0
enum { BY_TAILS = 3 }; /* in noise_made: excluded from this scan */
enum { MOST_CAUSES = 16, MOST_OUTLIERS = 12, ROUNDS = 4 };

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
        if (!(score->log_odds > -HUGE_VAL) || contest->noise_made[i] > 0) continue;
        const double odds = score->log_odds - contest->waiting[i];
        mukca_contender key = key_of(mukca_scan_candidate(scan, i));
        int at = key.class == MUKCA_CLASS_OUTLIER ? -1 : contest->n_table - 1;
        while (at >= 0 && !same_key(&contest->table[at], &key)) at--;
        if (at < 0) {
            at = contest->n_table++;
            contest->table[at] = key;
        }
        mukca_contender *c = &contest->table[at];
        if (c->best < 0 || odds > scan->score[c->best].log_odds - contest->waiting[c->best])
            c->best = i;
        const double hi = fmax(c->log_odds, odds), lo = fmin(c->log_odds, odds);
        c->log_odds = lo > -HUGE_VAL ? hi + log1p(exp(lo - hi)) : hi;
    }
    qsort(contest->table, (size_t)contest->n_table, sizeof *contest->table, by_odds);
}

/* Can an unknown function represent this contender?  Both must be functions of the same argument;
 * high-order ripple is too fine for its basis. */
static bool explains(const mukca_candidate *unknown, const mukca_competition *contest,
                     const mukca_contender *c)
{
    if (unknown->kind == MUKCA_CANDIDATE_OTHER_ANGLE ||
        unknown->kind == MUKCA_CANDIDATE_ANGLE_PRODUCT)
        return mukca_effect_has(c->class, MUKCA_TRAIT_OTHER_ANGLE);
    if (unknown->kind != MUKCA_CANDIDATE_OWN_ANGLE)
        return mukca_effect_has(c->class, MUKCA_TRAIT_OF_TIME);
    const mukca_candidate *best = mukca_scan_candidate(contest->scan, c->best);
    return mukca_effect_has(c->class, MUKCA_TRAIT_OWN_ANGLE) &&
           best->effect.variant.order <= MUKCA_SMOOTH_ORDER;
}

/* Does an accepted unknown function of the joint explain it already?  Then no such contender is
 * accepted after it, except the cause that is now excluded. */
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
        if (explains(h, contest, c)) return true;
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

static const mukca_contender *best_of(const mukca_competition *contest, int without, bool names)
{
    for (int i = 0; i < contest->n_table; i++) {
        const mukca_contender *c = &contest->table[i];
        if (names && c->class == MUKCA_CLASS_UNKNOWN) continue;
        if (!shadowed(contest, c, without) && !mukca_competition_taken(contest, c, without))
            return c;
    }
    return NULL;
}

void mukca_competition_save(mukca_search_state *state, const mukca_competition *contest)
{
    const mukca_regression *m = contest->m;
    mukca_unknowns_assign(&state->unknowns, &m->unknowns);
    memcpy(state->keep, m->recording.keep, (size_t)m->recording.data->n_rows);
    *state->faults = *contest->faults;
    state->steps = contest->scan->steps;
}

/* With names_first, an unknown function is chosen only if no named candidate passes the threshold,
 * and replaces a named cause only by a clear lead. */
static const mukca_contender *choose(mukca_competition *contest, int without, double threshold)
{
    const mukca_unknowns *u = &contest->m->unknowns;
    const mukca_contender *all = best_of(contest, without, false);
    if (!contest->names_first || !all || all->class != MUKCA_CLASS_UNKNOWN) return all;
    if (without >= 0 && mukca_candidate_class(&u->cause[without].candidate) == MUKCA_CLASS_UNKNOWN)
        return all;
    const mukca_contender *name = best_of(contest, without, true);
    if (!name || name->log_odds < threshold) return all;
    const bool clear = all->log_odds > name->log_odds + PREFERENCE;
    if (without >= 0) return clear ? all : name;
    if (!contest->parted) mukca_competition_save(&contest->parting, contest);
    contest->parted = true;
    contest->passed_over |= clear;
    return name;
}

/* Is the lead due to noise in the recorded angles alone? */
static bool made_by_noise(mukca_competition *contest, const mukca_contender *c, int without,
                          double threshold)
{
    signed char *known = &contest->noise_made[c->best];
    if (!*known) {
        const mukca_candidate *h = mukca_scan_candidate(contest->scan, c->best);
        const double gain = mukca_scan_noise_gain(contest->scan, contest->m, without, h);
        *known = c->log_odds - gain < threshold ? 1 : -1;
    }
    return *known > 0;
}

/* Does it displace a socket or the arm from some row on, or in one placement?  Outliers may imitate
 * such a shift. */
static bool is_shift(const mukca_candidate *h)
{
    return h->kind == MUKCA_CANDIDATE_STEP || h->kind == MUKCA_CANDIDATE_CREEP ||
           h->kind == MUKCA_CANDIDATE_SLIP ||
           mukca_effect_has(mukca_candidate_class(h), MUKCA_TRAIT_PER_PLACEMENT);
}

/* Is the lead of a shift due to the tails of the noise alone?  Then all equal shifts are excluded
 * from this scan. */
static bool made_by_tails(mukca_competition *contest, const mukca_contender *c, int without,
                          double threshold)
{
    const mukca_candidate *h = mukca_scan_candidate(contest->scan, c->best);
    if (!is_shift(h)) return false;
    const double gain = mukca_heavy_tails_gain(&contest->tails, contest->m, without, h);
    if (c->log_odds - gain >= threshold) return false;
    const mukca_contender key = *c;
    for (int i = 0; i < contest->scan->n_scores; i++) {
        const mukca_contender other = key_of(mukca_scan_candidate(contest->scan, i));
        if (same_key(&key, &other) && contest->noise_made[i] <= 0)
            contest->noise_made[i] = BY_TAILS;
    }
    return true;
}

/* Scan and rank. */
static void scan_and_rank(mukca_competition *contest, int without, mukca_scan_extent extent)
{
    for (int i = 0; i < contest->scan->capacity; i++)
        if (contest->noise_made[i] == BY_TAILS) contest->noise_made[i] = 0;
    mukca_scan_run(contest->scan, contest->m, without, extent);
    contest->tails.known = false;
    mukca_competition_rank(contest);
}

/* Next cause, or the replacement of the excluded one; NULL: none reaches the threshold. */
static const mukca_contender *leader(mukca_competition *contest, int without, double threshold)
{
    for (;;) {
        const mukca_contender *top = choose(contest, without, threshold);
        if (!top || top->log_odds < threshold) return NULL;
        if (!made_by_noise(contest, top, without, threshold) &&
            !made_by_tails(contest, top, without, threshold))
            return top;
        mukca_competition_rank(contest);
    }
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

bool mukca_competition_is_spring(const mukca_candidate *h)
{
    return mukca_effect_has(mukca_candidate_class(h), MUKCA_TRAIT_ELASTIC);
}

static bool add(mukca_competition *contest, const mukca_candidate *h)
{
    if (contest->names_first && !contest->sprung && mukca_competition_is_spring(h)) {
        mukca_competition_save(&contest->unsprung, contest);
        contest->sprung = true;
    }
    if (!mukca_unknowns_add(&contest->m->unknowns, h)) return false;
    contest->m->unknowns.cause[contest->m->unknowns.n_causes - 1].step = contest->scan->steps - 1;
    return true;
}

/* Accept a single outlier, and all others of at least these odds. */
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
    mukca_scan_extent extent = contest->n_first ? MUKCA_SCAN_LISTED : MUKCA_SCAN_ALL;
    while (m->unknowns.n_causes - outliers(m) < MOST_CAUSES && outliers(m) < MOST_OUTLIERS) {
        if (!watch(contest, "looking for causes", error)) return MUKCA_INTERRUPTED;
        scan_and_rank(contest, -1, extent);
        contest->scanned = true;
        if (!contest->n_first) {
            contest->n_first = contest->n_table;
            memcpy(contest->first, contest->table,
                   sizeof *contest->first * (size_t)contest->n_table);
            memcpy(contest->first_score, contest->scan->score,
                   sizeof *contest->first_score * (size_t)contest->scan->n_scores);
        }
        const double threshold = m->unknowns.n_causes ? LATER_THRESHOLD : FIRST_THRESHOLD;
        const mukca_contender *top = leader(contest, -1, threshold);
        if (!top) {
            if (extent == MUKCA_SCAN_LISTED) {
                extent = MUKCA_SCAN_RIPPLE; /* before stopping: all orders once more */
                continue;
            }
            if (!mukca_screening_reinstate(contest->faults, m)) return MUKCA_OK;
            mukca_regression_freeze(m);
        } else if (top->class == MUKCA_CLASS_OUTLIER) {
            if (!add_outliers(contest, fmax(threshold, 0.5 * top->log_odds))) return MUKCA_OK;
        } else if (!add(contest, mukca_scan_candidate(contest->scan, top->best))) {
            return MUKCA_OK;
        }
        extent = MUKCA_SCAN_LISTED;
        contest->scanned = false;
        mukca_regression_refit(m);
    }
    return MUKCA_OK;
}

void mukca_competition_leave_waiting(mukca_competition *contest)
{
    if (!contest->scanned) mukca_scan_run(contest->scan, contest->m, -1, MUKCA_SCAN_LISTED);
    const float *odds = mukca_scan_last_odds(contest->scan);
    for (int i = 0; i < contest->scan->n_scores; i++)
        contest->waiting[i] = (double)odds[i] < LATER_THRESHOLD ? 0 : (double)odds[i];
}

bool mukca_competition_leave_unlisted(mukca_competition *contest)
{
    const mukca_scan *scan = contest->scan;
    if (contest->left_unlisted) return false;
    contest->left_unlisted = true;
    mukca_scan_run(contest->scan, contest->m, -1, MUKCA_SCAN_UNLISTED);
    for (int i = contest->all->first_unlisted; i < contest->all->count; i++)
        contest->waiting[i] =
            scan->score[i].log_odds < LATER_THRESHOLD ? 0 : scan->score[i].log_odds;
    return true;
}

static bool any_unknown(const mukca_unknowns *u)
{
    for (int c = 0; c < u->n_causes; c++)
        if (mukca_candidate_class(&u->cause[c].candidate) == MUKCA_CLASS_UNKNOWN) return true;
    return false;
}

/* Drop a cause without evidence; false: it stays.  A named cause that an unknown function can
 * represent stays if the set with both is more probable. */
static bool drop(mukca_competition *contest, int c)
{
    mukca_regression *m = contest->m;
    const bool named = mukca_candidate_class(&m->unknowns.cause[c].candidate) < MUKCA_EFFECT_COUNT;
    const bool doubtful = contest->names_first && named && any_unknown(&m->unknowns);
    const double with = doubtful ? mukca_regression_score(m) : 0;
    mukca_unknowns_assign(&contest->kept, &m->unknowns);
    mukca_unknowns_drop(&m->unknowns, c);
    mukca_regression_refit(m);
    if (!doubtful || mukca_regression_score(m) >= with) {
        contest->scanned = false;
        return true;
    }
    mukca_unknowns_assign(&m->unknowns, &contest->kept);
    mukca_regression_return(m);
    return false;
}

/* Replace a cause by a candidate; after the first round only if the set gets more probable, which
 * guarantees termination.  Returns whether the candidate stays. */
static bool swap(mukca_competition *contest, int c, const mukca_candidate *best, bool first)
{
    mukca_regression *m = contest->m;
    mukca_unknowns *u = &m->unknowns;
    const double before = first ? -HUGE_VAL : mukca_regression_score(m);
    const int last = u->n_causes, step = u->cause[c].step;
    mukca_unknowns_assign(&contest->kept, u);
    if (!add(contest, best)) return false;
    u->cause[last].step = step;
    u->cause[c] = u->cause[last];
    u->n_causes = last;
    mukca_regression_refit(m);
    if (mukca_regression_score(m) > before) {
        contest->scanned = false;
        return true;
    }
    mukca_unknowns_assign(u, &contest->kept);
    mukca_regression_return(m);
    return false;
}

/* Lead over all other candidates outside the model, and over the threshold. */
static double lead_of(const mukca_competition *contest, const mukca_contender *top)
{
    double rival = FIRST_THRESHOLD;
    for (int i = 0; i < contest->n_table; i++)
        if (&contest->table[i] != top) rival = fmax(rival, contest->table[i].log_odds);
    return top->log_odds - rival;
}

/* Exclude each cause in turn, scan for the best replacement, and swap or drop; repeat until all
 * causes are tested against the same set, except those with a safe lead. */
mukca_status mukca_competition_settle(mukca_competition *contest, mukca_error *error)
{
    mukca_regression *m = contest->m;
    int settled = 0; /* causes tested since the last change */
    for (int round = 0; round < ROUNDS; round++) {
        for (int c = 0; c < m->unknowns.n_causes; c++) {
            if (settled++ == m->unknowns.n_causes) return MUKCA_OK;
            if (m->unknowns.cause[c].lead > SAFE_LEAD) continue;
            if (!watch(contest, "testing each cause again", error)) return MUKCA_INTERRUPTED;
            scan_and_rank(contest, c, MUKCA_SCAN_CONTENDERS);
            const mukca_contender *top = leader(contest, c, FIRST_THRESHOLD);
            if (!top) {
                if (drop(contest, c)) settled = 0, c--;
                continue;
            }
            m->unknowns.cause[c].lead = lead_of(contest, top);
            const mukca_candidate *best = mukca_scan_candidate(contest->scan, top->best);
            const mukca_candidate *now = &m->unknowns.cause[c].candidate;
            if (now->kind == MUKCA_CANDIDATE_OUTLIER || round + 1 == ROUNDS ||
                mukca_candidate_same(best, now))
                continue;
            if (swap(contest, c, best, round == 0)) settled = 0;
        }
    }
    return MUKCA_OK;
}

mukca_status mukca_competition_search(mukca_competition *contest, bool names_first,
                                      mukca_error *error)
{
    contest->names_first = names_first;
    mukca_status status = forward(contest, error);
    if (status == MUKCA_OK) status = mukca_competition_settle(contest, error);
    return status;
}
