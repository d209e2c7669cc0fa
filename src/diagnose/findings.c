/* Findings of a diagnosis: the posterior over sets of causes, with labels, and sizes. */
#include "diagnose/findings.h"

#include <math.h>
#include <stdlib.h>

#include "base/order.h"
#include "diagnose/cause.h"
#include "diagnose/halves.h"
#include "math/stats.h"

/* Probability of the sets that are left out: below what any statement resolves; of halves, what
 * their mean resolves. */
#define LEFT_OUT 5e-4
#define LEFT_OUT_OF_HALVES 0.01
/* Log odds behind the best set of the sets that are averaged, as of the whole. */
#define WINDOW 12.0

enum { MOST_SETS = 400 };

/* Number the labels of the items of the last search behind the first n of label[];
 * label_of[n_kept]: -1: outlier.  Returns the number of labels. */
static int number_labels(mukca_label *label, int n, int *label_of, const mukca_search *search)
{
    for (int i = 0; i < search->n_kept; i++) {
        const mukca_candidate *h = &search->all.list[search->kept[i]];
        label_of[i] = -1;
        if (mukca_candidate_class(h) == MUKCA_CLASS_OUTLIER) continue;
        const mukca_label l = mukca_candidate_label(h, &search->m->recording, &search->m->unknowns);
        label_of[i] = mukca_label_number(label, &n, &l);
    }
    return n;
}

/* A set with labels: its members that are no outliers. */
static void label_set(mukca_labelled_set *out, mukca_pool *pool, double *scratch, mukca_sets *sets,
                      const mukca_set *set, const int *label_of)
{
    double all[MUKCA_SET_ITEMS * MUKCA_SET_ITEMS];
    unsigned short *label = MUKCA_TAKE(pool, unsigned short, set->n + 1);
    double *product = MUKCA_TAKE(pool, double, set->n * set->n + 1);
    int member[MUKCA_SET_ITEMS], n = 0;
    if (pool->failed) return;
    mukca_sets_products(all, scratch, sets, set);
    for (int i = 0; i < set->n; i++)
        if (label_of[set->item[i]] >= 0) member[n++] = i;
    for (int i = 0; i < n; i++) {
        label[i] = (unsigned short)label_of[set->item[member[i]]];
        for (int k = 0; k < n; k++) product[i * n + k] = all[member[i] * set->n + member[k]];
    }
    out->n = n;
    out->label = label;
    out->product = product;
}

typedef struct {
    mukca_sets *sets;
    const int *label_of;      /* [n_items] */
    const mukca_ranked *list; /* [n] sets by falling probability, `odds` */
    int n;
    double left_out;
} weighted;

/* The sets with labels, and their weights; the caller checks the pool. */
static void label_posterior(mukca_labelled_sets *out, mukca_pool *pool, const weighted *w)
{
    mukca_labelled_set *set = MUKCA_TAKE(pool, mukca_labelled_set, MOST_SETS);
    double *scratch = MUKCA_TAKE(pool, double, w->sets->question->stride + 1), sum = 0;
    for (int i = 0; i < w->n && i < MOST_SETS && sum < 1 - w->left_out && !pool->failed; i++) {
        set[i].weight = w->list[i].odds;
        sum += set[i].weight;
        label_set(&set[i], pool, scratch, w->sets, &w->sets->set[w->list[i].index], w->label_of);
        out->n_sets = i + 1;
    }
    for (int i = 0; i < out->n_sets; i++) set[i].weight /= sum; /* the others alike */
    out->set = set;
}

MUKCA_FALLING(by_size, mukca_finding, size_m.value)

typedef struct {
    mukca_halves *halves;
    mukca_labelled_sets *out; /* [halves->n] */
    const int *label_of;      /* [halves->n_items] */
} labelling;

/* The posterior of a half: of the sets that its search met. */
static void label_half(void *context, int half, int worker)
{
    const labelling *job = context;
    mukca_pool *pool = &job->halves->pool[worker];
    mukca_sets *sets = &job->halves->half[half].sets;
    if (!sets->n_sets) return; /* says nothing */
    mukca_ranked *order = MUKCA_TAKE(pool, mukca_ranked, sets->n_sets);
    double *value = MUKCA_TAKE(pool, double, sets->n_sets);
    int n = 0;
    if (pool->failed) return;
    for (int k = 0; k < sets->n_sets; k++) order[k] = (mukca_ranked){sets->set[k].value, k};
    qsort(order, (size_t)sets->n_sets, sizeof *order, mukca_by_odds);
    for (; n < sets->n_sets && n < MOST_SETS && order[n].odds > order[0].odds - WINDOW; n++)
        value[n] = order[n].odds;
    const double sum = mukca_stats_log_sum_exp(value, n);
    for (int k = 0; k < n; k++) order[k].odds = exp(value[k] - sum);
    label_posterior(&job->out[half], pool,
                    &(weighted){sets, job->label_of, order, n, LEFT_OUT_OF_HALVES});
}

static mukca_status no_memory(mukca_error *error)
{
    return mukca_fail(error, MUKCA_MEMORY, "out of memory for the findings");
}

/* Search the halves, under the noise of the last search, and label their sets as the whole.  Those
 * without sets say nothing: out[] has the others, halves->n of them. */
static mukca_status label_halves(mukca_labelled_sets out[MUKCA_HALVES], mukca_halves *halves,
                                 mukca_pool *pool, mukca_search *search,
                                 const mukca_labelled_search *whole, mukca_error *error)
{
    int *label = MUKCA_TAKE(pool, int, search->n_kept + 1);
    if (pool->failed) return no_memory(error);
    for (int h = 0; h < MUKCA_HALVES; h++) {
        out[h] = whole->posterior;
        out[h].n_sets = 0;
    }
    MUKCA_TRY(mukca_halves_search(halves, pool, search, error));
    for (int i = 0; i < halves->n_items; i++) label[i] = whole->label_of[halves->item_of[i]];
    mukca_workers_run(search->m->recording.workers, halves->n, label_half,
                      &(labelling){halves, out, label});
    for (int k = 0; k < MUKCA_MOST_WORKERS; k++) pool->failed |= halves->pool[k].failed;
    int n = 0;
    for (int h = 0; h < halves->n; h++)
        if (out[h].n_sets) out[n++] = out[h];
    halves->n = n;
    return MUKCA_OK;
}

/* The last search with labels.  Those of a search before it, in *whole, keep their numbers: the
 * halves are of the first one. */
static mukca_status label_search(mukca_labelled_search *whole, mukca_pool *pool,
                                 mukca_search *search, mukca_error *error)
{
    const mukca_labelled_sets before = whole->posterior;
    mukca_label *label = MUKCA_TAKE(pool, mukca_label, before.n_labels + search->n_kept + 1);
    mukca_ranked *list = MUKCA_TAKE(pool, mukca_ranked, search->n_sets + 1);
    *whole = (mukca_labelled_search){.posterior = {.label = label, .least = MUKCA_FINDING_SQUARE},
                                     .label_of = MUKCA_TAKE(pool, int, search->n_kept + 1)};
    if (pool->failed) return no_memory(error);
    for (int i = 0; i < before.n_labels; i++) label[i] = before.label[i];
    whole->posterior.n_labels = number_labels(label, before.n_labels, whole->label_of, search);
    for (int i = 0; i < search->n_sets; i++)
        list[i] = (mukca_ranked){search->set[i].weight, search->set[i].index};
    label_posterior(&whole->posterior, pool,
                    &(weighted){&search->sets, whole->label_of, list, search->n_sets, LEFT_OUT});
    return pool->failed ? no_memory(error) : MUKCA_OK;
}

mukca_status mukca_findings_reach(mukca_diagnosis *d, mukca_search *search, mukca_error *error)
{
    mukca_pool pool = {0};
    mukca_finding_group *group = MUKCA_TAKE(&d->pool, mukca_finding_group, 2 * MUKCA_MOST_FINDINGS);
    mukca_labelled_search whole = {0};
    mukca_labelled_sets half[MUKCA_HALVES];
    mukca_halves *halves = MUKCA_TAKE(&pool, mukca_halves, 1);
    int n_findings = 0, n = -1;
    mukca_status status = label_search(&whole, &pool, search, error);
    if (status == MUKCA_OK) status = label_halves(half, halves, &pool, search, &whole, error);
    if (status == MUKCA_OK && search->tails) {
        status = mukca_identify_with_tails(search, error);
        if (status == MUKCA_OK) status = label_search(&whole, &pool, search, error);
    }
    if (status == MUKCA_OK && group && !pool.failed)
        n = mukca_findings_choose(group, &n_findings, &pool, &whole.posterior, half, halves->n);
    for (int i = 0; i < n; i++) {
        mukca_finding *f = i < n_findings ? &d->findings[d->n_findings++] : &d->maybe[d->n_maybe++];
        *f = (mukca_finding){.group = group[i], .held_out = MUKCA_SHRINK_NONE};
    }
    if (status == MUKCA_OK && n >= 0 && !mukca_findings_measure(d, &pool, search, &whole)) n = -1;
    qsort(d->findings, (size_t)d->n_findings, sizeof *d->findings, by_size);
    qsort(d->maybe, (size_t)d->n_maybe, sizeof *d->maybe, by_size);
    for (int i = 1; i < d->n_findings; i++)
        d->findings[i].group.beside_unknown = d->findings[i - 1].group.beside_unknown ||
                                              d->findings[i - 1].outside > MUKCA_VERDICT_HALF;
    if (halves) mukca_halves_free(halves);
    mukca_pool_free(&pool);
    return status == MUKCA_OK && n < 0 ? no_memory(error) : status;
}
