/* Posterior over sets of causes: passes of linearisation, scan and search.
 *
 * A pass linearises at the most probable set found so far, scores all candidates against the
 * geometry and against that set, and searches among the sets of the best of them.  It ends when the
 * set remains among the best.  At last the weights are averaged over the families of the noise. */
#include "diagnose/identify.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "diagnose/cause.h"
#include "math/stats.h"

enum {
    BUDGET = 36,       /* sets expanded in the last search without a better one */
    QUICK = 8,         /* in the searches before, which only have to find the best set */
    KEPT = 300,        /* candidates kept by their score against the geometry */
    KEPT_BESIDE = 100, /* by that against the set */
    MOST_KEPT = 3 * KEPT,
    MOST_NUMBERS = 8 << 20, /* of the kept columns: 64 MiB */
    SETS = 1000,
    EVALUATED = 300, /* of them; the others keep their estimate */
    FINE_SETS = 60   /* evaluated under each family of the noise */
};

/* Log odds behind the best set of the sets that are averaged, and behind the best family of those
 * that are left out: 160,000 to 1. */
#define AVERAGED 12.0
/* Length of the noise vector of a sample that is hardly exceeded, in sigmas (1 %). */
#define NOISE 3.4
/* Log odds to the best set, 20 to 1, within which the set of the last linearisation is the result:
 * what separates the two hardly shows, and ties would change places forever. */
#define SETTLED 3.0
/* Log odds below which a candidate is not kept. */
#define HOPELESS (-AVERAGED)

/* Set the causes of the unknowns, to be fitted. */
static void set_causes(mukca_search *search, const mukca_causes *set)
{
    mukca_unknowns *u = &search->m->unknowns;
    u->n_causes = u->n_models = 0;
    for (int i = 0; set && i < set->n; i++)
        if (mukca_unknowns_add(u, &search->all.list[set->candidate[i]]))
            u->cause[u->n_causes - 1].scale = set->scale[i], u->cause[u->n_causes - 1].sized = true;
}

void mukca_identify_fit(mukca_search *search, const mukca_causes *set)
{
    set_causes(search, set);
    mukca_regression_fit(search->m, 3, MUKCA_FIT_ALL);
}

/* Add the candidates with the best scores of the last scan to those kept. */
static void keep_best(mukca_search *search, int most)
{
    const mukca_scan *scan = &search->scan;
    const mukca_recording *r = &search->m->recording;
    mukca_ranked *order = search->ranked;
    long long numbers = 0;
    memset(search->taken, 0, (size_t)search->all.count);
    for (int i = 0; i < search->n_kept; i++) {
        search->taken[search->kept[i]] = 1;
        numbers += search->all.list[search->kept[i]].terms;
    }
    for (int i = 0; i < search->all.count; i++)
        order[i] = (mukca_ranked){scan->value[i] + search->all.list[i].log_prior, i};
    qsort(order, (size_t)search->all.count, sizeof *order, mukca_by_odds);
    for (int i = 0; i < search->all.count && i < most && search->n_kept < MOST_KEPT; i++) {
        if (!(order[i].odds > HOPELESS)) break;
        if (search->taken[order[i].index]) continue;
        numbers += search->all.list[order[i].index].terms;
        if (numbers * (r->n_samples * r->dim + scan->n) > MOST_NUMBERS) break;
        search->kept[search->n_kept++] = order[i].index;
    }
}

static int ascending(const void *a, const void *b)
{
    return *(const int *)a - *(const int *)b;
}

/* A set of the search as candidates. */
static mukca_causes causes_of(const mukca_search *search, const mukca_set *set)
{
    mukca_causes out = {.n = set->n};
    for (int i = 0; i < set->n; i++) {
        out.candidate[i] = search->kept[set->item[i]];
        out.scale[i] = search->question.item[set->item[i]].prior.size[set->size[i]];
    }
    return out;
}

/* Insert a set whose candidates are among index[n]; returns its index, -1: too large. */
static int insert(mukca_sets *sets, const mukca_causes *set, const int *index, int n)
{
    int item[MUKCA_SET_ITEMS], count = 0;
    double size[MUKCA_SET_ITEMS];
    for (int i = 0; i < n; i++)
        for (int k = 0; k < set->n; k++)
            if (set->candidate[k] == index[i]) item[count] = i, size[count++] = set->scale[k];
    return mukca_sets_insert(sets, item, size, count);
}

/* Was an earlier pass linearised at this set?  Then passes would alternate forever. */
static bool recurs(const mukca_search *search, const mukca_causes *set)
{
    const size_t size = sizeof *set->candidate * (size_t)set->n;
    bool found = false;
    for (const mukca_causes *p = search->passed; p < search->passed + search->n_passed; p++)
        found |= p->n == set->n && memcmp(p->candidate, set->candidate, size) == 0;
    return found;
}

/* Search among the sets of the kept candidates, from the empty set and from the best set so far. If
 * that is settled, or in the last pass, with all of the budget.  *best: the most probable set. */
static bool search_candidates(mukca_search *search, mukca_causes *best, bool last)
{
    mukca_pool *pool = &search->search_pool;
    mukca_pool_free(pool); /* of the last pass */
    /* the order in which they were kept does not matter */
    qsort(search->kept, (size_t)search->n_kept, sizeof *search->kept, ascending);
    set_causes(search, NULL);
    if (!mukca_scan_aim(&search->scan, search->m->unknowns.family) ||
        !mukca_scan_question(&search->question, &search->scan, pool, search->kept,
                             search->n_kept) ||
        !mukca_sets_create(&search->sets, pool, &search->question))
        return false;
    const mukca_sets *sets = &search->sets;
    const int before = insert(&search->sets, best, search->kept, search->n_kept);
    mukca_sets_explore(&search->sets, QUICK, false);
    const mukca_set *found = &sets->set[sets->best];
    const mukca_causes next = causes_of(search, found);
    search->settled = recurs(search, &next) || (before >= 0 && (best->n || !found->n) &&
                                                sets->set[before].value > found->value - SETTLED);
    search->passed[search->n_passed++] = *best;
    if (search->settled || last) mukca_sets_explore(&search->sets, BUDGET - QUICK, true);
    *best = causes_of(search, &sets->set[sets->best]);
    return !pool->failed;
}

static mukca_status no_memory(mukca_error *error)
{
    return mukca_fail(error, MUKCA_MEMORY, "out of memory for sets of causes");
}

/* A pass at the present linearisation: all candidates are scored beside the set found so far, at
 * first alone, but for those of the catalogue alone, which have been. */
static mukca_status pass(mukca_search *search, mukca_causes *best, bool last, mukca_error *error)
{
    const bool first = !search->n_passed;
    if (search->listed) return search_candidates(search, best, last) ? MUKCA_OK : no_memory(error);
    set_causes(search, best);
    if (!mukca_scan_aim(&search->scan, search->m->unknowns.family))
        return first ? mukca_fail(error, MUKCA_UNIDENTIFIABLE, "the normal equations are singular")
                     : MUKCA_OK;
    MUKCA_TRY(mukca_scan_run(&search->scan, error));
    keep_best(search, first ? KEPT : KEPT_BESIDE);
    if (first) mukca_untested_list(search->diagnosis, &search->scan);
    return search_candidates(search, best, last) ? MUKCA_OK : no_memory(error);
}

/* Log posterior of the first sets under another family; relative to the same of the search. */
static bool weigh_family(double *value, mukca_search *search, const mukca_causes *set, int n,
                         int family)
{
    mukca_pool pool = {0};
    mukca_question question;
    mukca_sets sets;
    int *index = MUKCA_TAKE(&pool, int, search->all.count), count = 0;
    unsigned char *used = MUKCA_TAKE(&pool, unsigned char, search->all.count);
    bool ok = !pool.failed && mukca_scan_aim(&search->scan, family);
    for (int i = 0; ok && i < n; i++)
        for (int k = 0; k < set[i].n; k++) used[set[i].candidate[k]] = 1;
    for (int i = 0; ok && i < search->all.count; i++)
        if (used[i]) index[count++] = i;
    ok = ok && mukca_scan_question(&question, &search->scan, &pool, index, count) &&
         mukca_sets_create(&sets, &pool, &question);
    for (int i = 0; ok && i < n; i++) {
        const int at = insert(&sets, &set[i], index, count);
        value[i] = search->scan.evidence + (at >= 0 ? sets.set[at].value : -HUGE_VAL);
    }
    search->pool.failed |= pool.failed;
    mukca_pool_free(&pool);
    return ok;
}

MUKCA_FALLING(by_weight, mukca_causes, weight)

/* Average the posterior of the sets of the last search over the families of the noise, and rank
 * them by it. */
static mukca_status average(mukca_search *search, mukca_error *error)
{
    mukca_sets *sets = &search->sets;
    const int searched = search->m->unknowns.family, noises = search->m->evidence.n_noises;
    mukca_ranked *order = MUKCA_TAKE(&search->pool, mukca_ranked, sets->n_sets);
    double *total = MUKCA_TAKE(&search->pool, double, SETS),
           *value = MUKCA_TAKE(&search->pool, double, SETS);
    search->set = MUKCA_TAKE(&search->pool, mukca_causes, SETS);
    if (search->pool.failed) return no_memory(error);
    int n = 0, index[EVALUATED];
    for (int i = 0; i < sets->n_sets; i++) order[i] = (mukca_ranked){sets->set[i].value, i};
    qsort(order, (size_t)sets->n_sets, sizeof *order, mukca_by_odds);
    for (; n < sets->n_sets && n < EVALUATED && order[n].odds > order[0].odds - AVERAGED; n++)
        index[n] = order[n].index;
    if (!mukca_sets_evaluate_all(sets, index, n)) return no_memory(error);
    for (int i = 0; i < sets->n_sets; i++) order[i].odds = sets->set[order[i].index].value;
    qsort(order, (size_t)sets->n_sets, sizeof *order, mukca_by_odds);
    for (n = 0; n < sets->n_sets && n < SETS && order[n].odds > order[0].odds - AVERAGED; n++) {
        search->set[n] = causes_of(search, &sets->set[order[n].index]);
        search->set[n].index = order[n].index;
        total[n] = search->scan.evidence + order[n].odds;
    }
    search->n_sets = n;
    const double best = total[0];
    const int fine = n < FINE_SETS ? n : FINE_SETS;
    set_causes(search, NULL);
    for (int f = 0; f < noises; f++) {
        if (f == searched || !weigh_family(value, search, search->set, 1, f) ||
            value[0] < best - AVERAGED)
            continue;
        if (!weigh_family(value, search, search->set, fine, f)) continue;
        for (int i = 0; i < n; i++) {
            const double weighed = i < fine ? value[i] : value[0] + order[i].odds - order[0].odds;
            const double hi = fmax(total[i], weighed);
            total[i] = hi + log(exp(total[i] - hi) + exp(weighed - hi));
        }
    }
    if (search->pool.failed) return no_memory(error);
    const double sum = mukca_stats_log_sum_exp(total, n);
    for (int i = 0; i < n; i++) search->set[i].weight = exp(total[i] - sum);
    qsort(search->set, (size_t)n, sizeof *search->set, by_weight);
    return MUKCA_OK;
}

/* Compute the functions of the angles at the present linearisation, with the tip moved by at most
 * `most`: of all candidates, or only of those kept. */
static void seat(mukca_search *search, double most, bool all)
{
    const mukca_linearisation *linear = &search->m->linear;
    if (!mukca_recording_seat(&search->m->recording, &search->m->pool, linear->seated,
                              linear->distance, most))
        return;
    memset(search->taken, all, (size_t)search->all.count);
    for (int i = 0; i < search->n_kept; i++) search->taken[search->kept[i]] = 1;
    mukca_candidates_fill(&search->all, search->taken);
}

/* Passes, from a set, until it remains.  tails (NULL: Gaussian noise): scratch of the weights. */
static mukca_status search_all(mukca_search *search, mukca_causes *best, double *tails,
                               mukca_error *error)
{
    mukca_regression *m = search->m;
    const mukca_diagnose_options *o = search->options;
    search->n_passed = 0;
    search->settled = false;
    if (!search->listed) search->n_kept = 0;
    for (int p = 1; p <= MUKCA_PASSES && !search->settled; p++) {
        const double done = (tails ? 1 : 0) + (p - 1.0) / MUKCA_PASSES;
        if (o->progress &&
            !o->progress(o->progress_context, 0.1 + 0.25 * done, "comparing sets of causes"))
            return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
        if (p > 1 || tails || search->listed) {
            mukca_identify_fit(search, best);
            if (!search->listed && mukca_screening_reinstate(search->diagnosis, m))
                mukca_identify_fit(search, best);
            seat(search, NOISE * m->unknowns.sigma, !search->listed);
            mukca_regression_freeze(m);
        }
        mukca_regression_choose_share(m);
        if (tails) mukca_regression_choose_tails(m, tails);
        MUKCA_TRY(pass(search, best, p == MUKCA_PASSES, error));
    }
    return MUKCA_OK;
}

/* Is Student's noise more probable, with the set or with none? */
static bool has_heavy_tails(mukca_search *search, const mukca_causes *set, double *tails)
{
    mukca_unknowns *u = &search->m->unknowns;
    const mukca_causes *sets[] = {set, NULL};
    const double sigma = u->sigma;
    double value[2];
    bool heavy[2];
    for (int k = 0; k < 2; k++) {
        set_causes(search, sets[k]);
        mukca_regression_return(search->m);
        value[k] = mukca_regression_choose_tails(search->m, tails);
        heavy[k] = u->tails;
        u->sigma = sigma;
    }
    u->tails = NULL;
    mukca_evidence_renew(&search->m->evidence);
    return heavy[0] || (heavy[1] && value[1] > value[0]);
}

mukca_status mukca_identify_run(mukca_search *search, mukca_error *error)
{
    mukca_regression *m = search->m;
    mukca_causes best = {0};
    mukca_recording_seat(&m->recording, &m->pool, m->linear.seated, m->linear.distance,
                         NOISE * m->unknowns.sigma);
    mukca_candidates_start(&search->all, &m->pool, &m->recording, search->options->disabled);
    MUKCA_TRY(mukca_candidates_list(&search->all, &m->unknowns, error));
    search->kept = MUKCA_TAKE(&search->pool, int, MOST_KEPT);
    search->ranked = MUKCA_TAKE(&search->pool, mukca_ranked, search->all.capacity);
    search->taken = MUKCA_TAKE(&search->pool, unsigned char, search->all.capacity);
    double *tails = MUKCA_TAKE(&search->pool, double, m->recording.data->n_rows);
    if (!mukca_scan_create(&search->scan, &search->pool, m, &search->all))
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the scan of %d candidates",
                          search->all.count);
    mukca_regression_freeze(m);
    MUKCA_TRY(search_all(search, &best, NULL, error));
    if (!m->recording.repeats && has_heavy_tails(search, &best, tails)) search->tails = tails;
    return average(search, error);
}

mukca_status mukca_identify_with_tails(mukca_search *search, mukca_error *error)
{
    mukca_causes best = {0}; /* causes that only explain large errors are not to persist */
    MUKCA_TRY(search_all(search, &best, search->tails, error));
    return average(search, error);
}

static bool is_listed(const mukca_search *search, int candidate)
{
    return search->all.list[candidate].kind != MUKCA_CANDIDATE_UNLISTED;
}

mukca_status mukca_identify_listed(mukca_search *search, mukca_error *error)
{
    mukca_causes best = {0};
    const mukca_causes *set = &search->set[0];
    int n = 0;
    for (int i = 0; i < search->n_kept; i++)
        if (is_listed(search, search->kept[i])) search->kept[n++] = search->kept[i];
    for (int i = 0; i < set->n; i++)
        if (is_listed(search, set->candidate[i])) {
            best.candidate[best.n] = set->candidate[i];
            best.scale[best.n++] = set->scale[i];
        }
    search->n_kept = n;
    search->listed = true;
    MUKCA_TRY(search_all(search, &best, search->tails, error));
    return average(search, error);
}

void mukca_identify_settle(mukca_search *search)
{
    mukca_regression *m = search->m;
    m->unknowns.tails = NULL;
    seat(search, 0, false);                    /* a cause acts at the recorded angles */
    mukca_evidence_set_share(&m->evidence, 0); /* least squares: unexplained errors are no noise */
    mukca_identify_fit(search, &search->set[0]);
}

void mukca_identify_free(mukca_search *search)
{
    mukca_pool_free(&search->search_pool);
    mukca_pool_free(&search->pool);
}
