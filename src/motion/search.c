/* Search among sets of effects: passes of scoring, search, noise and linearisation. */
#include "motion/search.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "math/stats.h"

enum {
    PASSES = 8,
    KEPT = 140,     /* items of a search: the best by their scores beside the best set so far */
    TOGETHER = 300, /* columns that are scored together */
    QUICK = 12,     /* sets expanded in a pass; then in the last one */
    BUDGET = 40,
    HALF = 20 /* in a half */
};

/* Log odds behind the best set of the sets that are averaged, and their part that is left out. */
#define WINDOW 12.0
/* Delay that is settled, s: far below the step of any controller. */
#define SETTLED 2e-4

/* Score all items beside a set that is held. */
static bool score(mukca_ranked *out, const mukca_torques *t, const mukca_torque_set *held)
{
    const mukca_items *all = &t->items;
    bool ok = true;
    for (int first = 0; first < all->n_items && ok;) {
        mukca_pool pool = {0};
        mukca_question question;
        mukca_sets *sets = MUKCA_TAKE(&pool, mukca_sets, 1);
        int *item = MUKCA_TAKE(&pool, int, all->n_items), n = 0, columns = 0;
        while (!pool.failed && first + n < all->n_items && columns < TOGETHER)
            item[n] = first + n, columns += all->item[first + n++].terms;
        ok = !pool.failed &&
             mukca_torques_ask(&question, &pool, t, &(mukca_torque_choice){n, item, held},
                               &mukca_torques_whole) &&
             mukca_sets_create(sets, &pool, &question) && mukca_sets_weigh(sets, &sets->set[0]);
        for (int i = 0; i < n && ok; i++)
            out[first + i] = (mukca_ranked){sets->added[i], first + i};
        first += n;
        mukca_pool_free(&pool);
    }
    return ok;
}

static bool holds(const mukca_torque_set *set, int item)
{
    for (int i = 0; i < set->n; i++)
        if (set->item[i] == item) return true;
    return false;
}

/* Keep the best items, those of the set, and the best without a set. */
static void keep(mukca_torque_search *s, mukca_ranked *alone, mukca_ranked *beside,
                 const mukca_torque_set *best)
{
    const int n = s->t->items.n_items;
    unsigned char *in = MUKCA_TAKE(&s->pool, unsigned char, n);
    if (!in) return;
    qsort(beside, (size_t)n, sizeof *beside, mukca_by_odds);
    for (int i = 0; i < n; i++) in[beside[i].index] |= i < KEPT / 2 || holds(best, beside[i].index);
    for (int i = 0; i < n && i < KEPT / 2; i++) in[alone[i].index] = 1;
    s->n_kept = 0;
    for (int i = 0; i < n; i++)
        if (in[i]) s->kept[s->n_kept++] = i;
}

static mukca_torque_set set_of(const mukca_torque_search *s, int index)
{
    const mukca_set *set = &s->sets.set[index];
    mukca_torque_set out = {.n = set->n};
    for (int i = 0; i < set->n; i++) {
        out.item[i] = s->kept[set->item[i]];
        out.size[i] = s->question.item[set->item[i]].prior.size[set->size[i]];
    }
    return out;
}

/* Insert a set of items of t->items. */
static void insert(mukca_torque_search *s, const mukca_torque_set *set)
{
    int item[MUKCA_SET_ITEMS], n = 0;
    double size[MUKCA_SET_ITEMS];
    for (int k = 0; k < s->n_kept; k++)
        for (int i = 0; i < set->n; i++)
            if (set->item[i] == s->kept[k]) item[n] = k, size[n++] = set->size[i];
    mukca_sets_insert(&s->sets, item, size, n);
}

static bool begin(mukca_torque_search *s, const mukca_part_weights *parts)
{
    return mukca_torques_ask(&s->question, &s->pool, s->t,
                             &(mukca_torque_choice){s->n_kept, s->kept, NULL}, parts) &&
           mukca_sets_create(&s->sets, &s->pool, &s->question);
}

/* The most probable sets, with weights. */
static void average(mukca_torque_search *s)
{
    mukca_sets *sets = &s->sets;
    mukca_ranked *order = MUKCA_TAKE(&s->pool, mukca_ranked, sets->n_sets);
    if (!order) return;
    for (int i = 0; i < sets->n_sets; i++) order[i] = (mukca_ranked){sets->set[i].value, i};
    qsort(order, (size_t)sets->n_sets, sizeof *order, mukca_by_odds);
    for (int i = 0; i < sets->n_sets; i++) {
        if (i < 2 * MUKCA_TORQUE_SETS && order[i].odds > order[0].odds - WINDOW)
            mukca_sets_evaluate(sets, order[i].index);
        order[i].odds = sets->set[order[i].index].value;
    }
    qsort(order, (size_t)sets->n_sets, sizeof *order, mukca_by_odds);
    for (s->n_sets = 0; s->n_sets < sets->n_sets && s->n_sets < MUKCA_TORQUE_SETS &&
                        order[s->n_sets].odds > order[0].odds - WINDOW;
         s->n_sets++)
        s->set[s->n_sets] = order[s->n_sets].index, s->weight[s->n_sets] = order[s->n_sets].odds;
    const double sum = mukca_stats_log_sum_exp(s->weight, s->n_sets);
    for (int i = 0; i < s->n_sets; i++) s->weight[i] = exp(s->weight[i] - sum);
}

/* Add a column of a link, times x, to the links that load the joints. */
static void add_load(mukca_torques *t, int column, double x)
{
    for (int r = t->items.first[column]; r < t->items.first[column + 1]; r++) {
        const mukca_raw_term *of = &t->items.term[r];
        if (of->raw < MUKCA_INERTIAL) /* the joint's own link */
            t->point.load[of->joint * MUKCA_INERTIAL + of->raw] += x * of->weight;
    }
}

/* Linearise at a set: its load, its delays, its friction, and the torque on which a gain acts.
 * Returns the change of the delays, s. */
static double linearise(mukca_torque_search *s, const mukca_torque_set *set)
{
    mukca_torques *t = s->t;
    mukca_pool pool = {0};
    mukca_items *all = &t->items;
    double delay[MUKCA_MAX_JOINTS] = {0}, change = 0;
    const mukca_torque_columns c = mukca_torque_columns_of(&pool, t, set, 0);
    double *mean = MUKCA_TAKE(&pool, double, c.n);
    bool ok = !pool.failed && mukca_torques_fit(mean, t, &c, &mukca_torques_whole);
    for (int j = 0; j < t->n && ok; j++)
        mukca_raw_nominal(t->point.torque[j], &t->model, &t->input->drives, j);
    memcpy(t->point.load, t->model.inertial, sizeof t->point.load);
    s->loads = false;
    for (int k = 0, at = all->n_parameters; k < set->n && ok; k++) {
        const int item = set->item[k], row = all->row[item];
        for (int i = at; mukca_torque_table[row].links && i < at + all->item[item].terms; i++)
            add_load(t, c.column[i], c.factor[i] * mean[i]);
        const mukca_label *l = &all->label[item];
        s->loads |= l->family == MUKCA_TORQUE_LOAD;
        if (mukca_torque_table[row].n == MUKCA_COLUMNS_RATE)
            for (int j = l->apart ? 0 : l->from; j <= (l->apart ? t->n - 1 : l->to); j++)
                delay[j] += mean[at] * set->size[k];
        at += all->item[item].terms;
    }
    memcpy(t->point.coulomb, t->input->drives.coulomb, sizeof t->point.coulomb);
    for (int i = 0; i < c.n - 1 && ok; i++)
        for (int r = all->first[c.column[i]]; r < all->first[c.column[i] + 1]; r++) {
            const mukca_raw_term *of = &all->term[r];
            if (of->raw == mukca_raw_local(t->n, of->joint, MUKCA_RAW_SIGN))
                t->point.coulomb[of->joint] += mean[i] * c.factor[i] * of->weight;
        }
    const int gains = all->n_parameters - all->n_gains;
    for (int i = 0; i < gains && ok; i++) {
        add_load(t, i, mean[i]);
        for (int r = all->first[i]; r < all->first[i + 1]; r++)
            t->point.torque[all->term[r].joint][all->term[r].raw] += mean[i] * all->term[r].weight;
    }
    const int shifts = MUKCA_SHIFTS / 2; /* to either side */
    const double most = shifts * t->model.shift * t->model.signals->dt;
    for (int j = 0; j < t->n && ok; j++) {
        delay[j] = fmin(fmax(delay[j], -most), most);
        if (fabs(delay[j]) < SETTLED) delay[j] = 0; /* a chord has a length */
        change = fmax(change, fabs(delay[j] - t->point.delay[j]));
        t->point.delay[j] = delay[j];
    }
    mukca_pool_free(&pool);
    return change;
}

mukca_status mukca_torque_search_run(mukca_torque_search *s, mukca_pool *pool, mukca_error *error)
{
    mukca_torques *t = s->t;
    mukca_torque_set best = {0}, none = {0};
    const int n = t->items.n_items;
    mukca_ranked *alone = MUKCA_TAKE(pool, mukca_ranked, n),
                 *beside = MUKCA_TAKE(pool, mukca_ranked, n);
    s->kept = MUKCA_TAKE(pool, int, n);
    bool ok = !pool->failed && mukca_torques_measure_noise(t, &none);
    for (int pass = 0, settled = 0; ok; pass++) {
        const bool last = settled || pass + 1 == PASSES;
        mukca_pool_free(&s->pool);
        ok = score(alone, t, &none) && score(beside, t, &best);
        if (!ok) break;
        qsort(alone, (size_t)n, sizeof *alone, mukca_by_odds);
        keep(s, alone, beside, &best);
        ok = begin(s, &mukca_torques_whole);
        if (!ok) break;
        insert(s, &best);
        mukca_sets_explore(&s->sets, last ? BUDGET : QUICK, last);
        const mukca_torque_set found = set_of(s, s->sets.best);
        if (last) break;
        mukca_pool_free(&s->pool);
        const double change = linearise(s, &found);
        /* the next pass has other columns */
        mukca_pool_free(&s->columns);
        ok = mukca_items_list(&t->items, &s->columns, t->input, &t->model, &t->point) &&
             mukca_torques_measure_noise(t, &found);
        settled = change < SETTLED && found.n == best.n &&
                  memcmp(found.item, best.item, sizeof *best.item * (size_t)best.n) == 0;
        best = found;
    }
    if (ok) average(s);
    if (ok && !s->pool.failed) return MUKCA_OK;
    return pool->failed || s->pool.failed
               ? mukca_fail(error, MUKCA_MEMORY, "out of memory for sets of effects")
               : mukca_fail(error, MUKCA_UNIDENTIFIABLE, "the normal equations are singular");
}

void mukca_torque_search_free(mukca_torque_search *s)
{
    mukca_pool_free(&s->pool);
    mukca_pool_free(&s->columns);
}

bool mukca_torque_search_half(mukca_torque_search *half, const mukca_torque_search *whole,
                              int number)
{
    /* four balanced divisions of eight interleaved blocks: the rows of a Hadamard matrix */
    static const int masks[MUKCA_HALVES / 2] = {1, 2, 4, 7};
    mukca_part_weights parts = {.of = {[MUKCA_PART_REFERENCE] = 1}};
    for (int b = 0; b < MUKCA_BLOCKS; b++)
        parts.of[b] = (__builtin_popcount((unsigned)(b & masks[number / 2])) + number) % 2;
    *half = (mukca_torque_search){.t = whole->t, .n_kept = whole->n_kept, .kept = whole->kept};
    bool ok = begin(half, &parts);
    if (ok) mukca_sets_explore(&half->sets, HALF, false);
    if (ok) average(half);
    return ok && !half->pool.failed;
}
