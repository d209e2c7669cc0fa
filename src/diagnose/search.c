/* Search for the most probable set of causes, from several starts. */
#include "diagnose/search.h"

#include <string.h>

/* Preference for a set of named causes over one with an unknown function, log odds (20 to 1). */
#define PREFERENCE 3.0
/* Elastic causes with this canonical correlation are the same by two names. */
#define SAME_SPRING 0.99
enum { BARRED = 2 }; /* in noise_made: excluded from this search */

/* Exclude the elastic cause accepted first, and its equivalents (a tilting base and bending at the
 * first joint), if the set contains another one; false: it does not. */
static bool bar_first_spring(mukca_competition *contest)
{
    mukca_regression *m = contest->m;
    const mukca_unknowns *u = &m->unknowns;
    int first = -1, springs = 0;
    for (int c = 0; c < u->n_causes; c++) {
        if (!mukca_competition_is_spring(&u->cause[c].candidate)) continue;
        springs++;
        if (first < 0 || u->cause[c].step < u->cause[first].step) first = c;
    }
    if (springs < 2) return false;
    const mukca_candidate *barred = &u->cause[first].candidate;
    mukca_scan_weigh(contest->scan, m, first);
    for (int i = 0; i < contest->all->first_unlisted; i++) {
        const mukca_candidate *h = &contest->all->list[i];
        if (mukca_competition_is_spring(h) &&
            (mukca_candidate_same(h, barred) ||
             mukca_scan_correlation(contest->scan, m, first, h, barred) > SAME_SPRING))
            contest->noise_made[i] = BARRED;
    }
    return true;
}

/* Allocate a state of the search. */
static bool reserve(mukca_search_state *state, mukca_regression *m)
{
    state->keep = MUKCA_TAKE(&m->pool, unsigned char, m->recording.data->n_rows);
    state->faults = MUKCA_TAKE(&m->pool, mukca_faults, 1);
    return mukca_unknowns_clone(&state->unknowns, &m->pool, &m->unknowns) && !m->pool.failed;
}

/* Return to a state, with its rows in use. */
static void restore(mukca_competition *contest, const mukca_search_state *state)
{
    mukca_regression *m = contest->m;
    const size_t rows = (size_t)m->recording.data->n_rows;
    mukca_unknowns_assign(&m->unknowns, &state->unknowns);
    if (memcmp(m->recording.keep, state->keep, rows) != 0) {
        memcpy(m->recording.keep, state->keep, rows);
        mukca_recording_regroup(&m->recording);
        mukca_regression_freeze(m);
    } else {
        mukca_regression_return(m);
    }
    *contest->faults = *state->faults;
    contest->scanned = false;
}

/* Search again from a state; the previous set stays unless the new one leads by `lead`.
 * `before` is scratch. */
static mukca_status search_again(mukca_competition *contest, const mukca_search_state *from,
                                 mukca_search_state *before, bool names_first, double lead,
                                 mukca_error *error)
{
    const double score = mukca_regression_score(contest->m);
    mukca_competition_save(before, contest);
    restore(contest, from);
    const int later = mukca_scan_repeat(contest->scan, from->steps);
    for (int c = 0; c < contest->m->unknowns.n_causes; c++)
        contest->m->unknowns.cause[c].step += later;
    const mukca_status status = mukca_competition_search(contest, names_first, error);
    if (status == MUKCA_OK && mukca_regression_score(contest->m) < score + lead)
        restore(contest, before);
    return status;
}

/* The result must not depend on the order of acceptance.  First search: named causes first.  Second
 * search, if an unknown function led on the way: from there, by the lead alone.  Third search, if
 * elastic causes share the deflection: without the one accepted first, from the state before any
 * elastic cause; one that approximates all of them, such as a tilting base, precedes the two that
 * explain it fully.  The most probable set wins, named causes preferred.  Rows may be reinstated on
 * the way: each search has its own. */
static mukca_status search_all(mukca_competition *contest, mukca_error *error)
{
    mukca_regression *m = contest->m;
    mukca_search_state before = {0};
    if (!reserve(&contest->parting, m) || !reserve(&contest->unsprung, m) || !reserve(&before, m) ||
        !mukca_unknowns_clone(&contest->kept, &m->pool, &m->unknowns))
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the competition of causes");
    mukca_competition_save(&contest->unsprung, contest);
    mukca_status status = mukca_competition_search(contest, true, error);
    if (status == MUKCA_OK && contest->passed_over)
        status = search_again(contest, &contest->parting, &before, false, PREFERENCE, error);
    if (status == MUKCA_OK && bar_first_spring(contest)) {
        const double score = mukca_regression_score(m);
        status = search_again(contest, &contest->unsprung, &before, true, 0, error);
        for (int i = 0; i < contest->scan->capacity; i++)
            if (contest->noise_made[i] == BARRED) contest->noise_made[i] = 0;
        /* an excluded candidate may replace another one of the new set */
        const bool changed = mukca_regression_score(m) != score;
        for (int c = 0; changed && c < m->unknowns.n_causes; c++) m->unknowns.cause[c].lead = 0;
        if (status == MUKCA_OK && changed) status = mukca_competition_settle(contest, error);
    }
    return status;
}

mukca_status mukca_search_run(mukca_competition *contest, mukca_error *error)
{
    mukca_pool *pool = &contest->m->pool;
    const int most = contest->scan->capacity;
    contest->table = MUKCA_TAKE(pool, mukca_contender, most);
    contest->first = MUKCA_TAKE(pool, mukca_contender, most);
    contest->first_score = MUKCA_TAKE(pool, mukca_score, most);
    contest->noise_made = MUKCA_TAKE(pool, signed char, most);
    contest->waiting = MUKCA_TAKE(pool, double, most);
    if (!mukca_heavy_tails_create(&contest->tails, pool, contest->m))
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the competition of causes");
    mukca_regression_freeze(contest->m);
    const mukca_status status = search_all(contest, error);
    /* on the columns of the search, whose products exist */
    if (contest->m->unknowns.n_causes) mukca_competition_leave_waiting(contest);
    mukca_regression_fit(contest->m, 3, MUKCA_FIT_ALL);
    return status;
}
