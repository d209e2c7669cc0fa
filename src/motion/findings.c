/* Findings from the posterior over sets of effects. */
#include "motion/findings.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"

static void number_labels(mukca_torque_posterior *p)
{
    const mukca_torque_search *s = p->search;
    for (int i = 0; i < s->n_kept; i++)
        p->label_of[i] = mukca_label_number(p->label, &p->n_labels, &s->t->items.label[s->kept[i]]);
}

/* Products of the torques of all items in the sets, joint by joint. */
static bool find_products(mukca_torque_posterior *p, mukca_pool *pool)
{
    const mukca_torque_search *s = p->search;
    int n = 0;
    p->at = MUKCA_TAKE(pool, int, s->n_kept + 1);
    if (pool->failed) return false;
    for (int i = 0; i < s->n_kept; i++) p->at[i] = -1;
    for (int k = 0; k < s->n_sets; k++)
        for (int m = 0; m < s->sets.set[s->set[k]].n; m++) {
            const int i = s->sets.set[s->set[k]].item[m];
            if (p->at[i] < 0) n += s->question.item[i].terms;
            p->at[i] = 0;
        }
    p->columns = mukca_torque_columns_take(pool, n);
    if (pool->failed) return false;
    for (int i = 0; i < s->n_kept; i++) {
        if (p->at[i] < 0) continue;
        p->at[i] = p->columns.n;
        mukca_torque_columns_item(&p->columns, s->t, s->kept[i], 1);
    }
    mukca_part_weights parts = mukca_torques_whole;
    parts.of[MUKCA_PART_REFERENCE] = 0;
    bool ok = true;
    for (int j = 0; j < s->t->n && ok; j++) {
        p->rows[j] = mukca_torques_rows(s->t, &parts, j);
        p->plain[j] = MUKCA_TAKE(pool, double, n *n + 1);
        ok =
            p->plain[j] && mukca_torques_multiply(p->plain[j], s->t, &p->columns, &parts, j, false);
    }
    return ok;
}

/* Largest rms torque of an item at a joint, relative to that joint's range. */
static double relevance(const mukca_torque_posterior *p, int item, const double *mean)
{
    double most = 0;
    int index[MUKCA_SET_COLUMNS];
    const mukca_item *h = &p->search->question.item[item];
    for (int a = 0; a < h->terms; a++) index[a] = p->at[item] + a;
    for (int j = 0; j < p->search->t->n; j++)
        most = fmax(most, sqrt(mukca_torque_square(NULL, p, j, index, mean + h->at, h->terms)) /
                              p->search->t->model.signals->range[j]);
    return most;
}

/* The sets with labels; without members that matter to nobody. */
static bool label_sets(mukca_torque_posterior *p, mukca_pool *pool)
{
    mukca_torque_search *s = p->search;
    mukca_labelled_set *set = MUKCA_TAKE(pool, mukca_labelled_set, s->n_sets + 1);
    double *mean = MUKCA_TAKE(pool, double, s->question.stride + 1);
    for (int k = 0; k < s->n_sets && !pool->failed; k++) {
        const mukca_set *of = &s->sets.set[s->set[k]];
        double all[MUKCA_SET_ITEMS * MUKCA_SET_ITEMS];
        int member[MUKCA_SET_ITEMS], n = 0;
        mukca_sets_products(all, mean, &s->sets, of);
        for (int m = 0; m < of->n; m++)
            if (relevance(p, of->item[m], mean) >= MUKCA_MOTION_RELEVANT) member[n++] = m;
        unsigned short *label = MUKCA_TAKE(pool, unsigned short, n + 1);
        double *product = MUKCA_TAKE(pool, double, n *n + 1);
        for (int a = 0; a < n && !pool->failed; a++) {
            label[a] = (unsigned short)p->label_of[of->item[member[a]]];
            for (int b = 0; b < n; b++) product[a * n + b] = all[member[a] * of->n + member[b]];
        }
        set[k] = (mukca_labelled_set){
            .weight = s->weight[k], .n = n, .label = label, .product = product};
    }
    p->posterior = (mukca_labelled_sets){.n_labels = p->n_labels,
                                         .n_sets = s->n_sets,
                                         .label = p->label,
                                         .set = set,
                                         .least = MUKCA_FINDING_SQUARE,
                                         .separate = true};
    return !pool->failed && !s->sets.pool->failed;
}

static void decide(mukca_motion *m)
{
    double named = 0, whole = 0;
    m->verdict = MUKCA_MOTION_NONE;
    for (int i = 0; i < m->n_findings; i++) {
        const mukca_finding_group *g = &m->finding[i].group;
        const bool exact = g->kind <= MUKCA_GROUP_EFFECT && g->from == g->to;
        named += exact ? m->finding[i].share : 0;
        whole += m->finding[i].share;
    }
    if (!m->n_findings) return;
    m->verdict = m->finding[0].outside > 0.5 ? MUKCA_MOTION_UNKNOWN
                 : named >= 0.5 * whole      ? MUKCA_MOTION_NAMED
                                             : MUKCA_MOTION_TIED;
}

MUKCA_FALLING(by_size, mukca_motion_finding, size_percent)

static bool find_all(mukca_motion *motion, mukca_torque_search *search, mukca_pool *pool)
{
    mukca_torque_posterior whole = {.search = search};
    mukca_labelled_sets half[MUKCA_HALVES];
    int n_findings = 0;
    whole.label = MUKCA_TAKE(pool, mukca_label, search->n_kept + 1);
    whole.label_of = MUKCA_TAKE(pool, int, search->n_kept + 1);
    if (pool->failed) return false;
    number_labels(&whole);
    bool ok = find_products(&whole, pool) && label_sets(&whole, pool);
    for (int h = 0; h < MUKCA_HALVES && ok; h++) {
        mukca_torque_search part = {0};
        mukca_torque_posterior p = whole;
        p.search = &part;
        ok = mukca_torque_search_half(&part, search, h) && find_products(&p, pool) &&
             label_sets(&p, pool);
        half[h] = p.posterior;
        mukca_torque_search_free(&part);
    }
    if (!ok) return false;
    const int n = mukca_findings_choose(motion->group, &n_findings, pool, &whole.posterior, half,
                                        MUKCA_HALVES);
    for (int i = 0; i < n; i++) {
        mukca_motion_finding *f = i < n_findings ? &motion->finding[motion->n_findings++]
                                                 : &motion->maybe[motion->n_maybe++];
        *f = (mukca_motion_finding){.group = motion->group[i]};
    }
    if (n < 0 || !mukca_torque_sizes(motion, pool, &whole)) return false;
    if (!mukca_torque_held_out(motion, &whole)) return false;
    qsort(motion->finding, (size_t)motion->n_findings, sizeof *motion->finding, by_size);
    qsort(motion->maybe, (size_t)motion->n_maybe, sizeof *motion->maybe, by_size);
    decide(motion);
    return true;
}

mukca_status mukca_torque_findings(mukca_motion *motion, mukca_torque_search *search,
                                   mukca_error *error)
{
    mukca_pool pool = {0};
    const bool ok = find_all(motion, search, &pool);
    mukca_pool_free(&pool);
    return ok ? MUKCA_OK : mukca_fail(error, MUKCA_MEMORY, "out of memory for the findings");
}
