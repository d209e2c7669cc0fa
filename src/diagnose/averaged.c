/* What a diagnosis applies: the mean over the probable sets of causes.
 *
 * Named causes are applied.  A tie without a name and a function outside the catalogue are not, but
 * causes of the catalogue explain most of the same.  So the mean of all causes over the sets
 * without such functions is fitted, too, and taken where it predicts held-out samples better. */
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "diagnose/cause.h"
#include "diagnose/findings.h"
#include "diagnose/held_out.h"

/* Least posterior probability of a cause, and of a set, that is averaged: less than this is no
 * reserve either (MUKCA_DOUBT). */
#define NEGLIGIBLE MUKCA_DOUBT

/* Part of the folds in which the causes of the catalogue alone must predict better: by chance,
 * eight of ten do in 5 % of cases. */
#define CONSISTENT 0.8

enum { MOST = 200 /* different combinations of named causes */ };

/* The named causes of a set, as bits of the list of all of them. */
typedef struct {
    uint64_t in;
    double weight;
} selection;

typedef struct {
    const mukca_search *search;
    bool every; /* all causes of the catalogue are applied, not only those named */
    int n, candidate[MUKCA_MAX_ACCEPTED]; /* the named causes */
    double scale[MUKCA_MAX_ACCEPTED], weight[MUKCA_MAX_ACCEPTED];
    int n_selections;
    selection list[MOST];
} naming;

/* Is a candidate a member of a finding, or a cause that is listed by its own probability?  Unknown
 * functions fit these samples, but do not predict others. */
static bool is_named(const naming *all, const mukca_candidate *h)
{
    const mukca_search *search = all->search;
    const mukca_diagnosis *d = search->diagnosis;
    if (h->kind != MUKCA_CANDIDATE_EFFECT) return false;
    const mukca_label label = mukca_candidate_label(h, &search->m->recording, &search->m->unknowns);
    bool named = all->every;
    for (int f = 0; f < d->n_findings && !named; f++)
        named = mukca_finding_holds(&d->findings[f].group, &label);
    for (int c = 0; c < d->n_causes && !named; c++)
        named = mukca_effect_same(&h->effect, &d->causes[c].effect);
    return named;
}

/* Bit of a named candidate, which is new or in the list; 0: no room. */
static uint64_t bit_of(naming *all, int candidate, double scale)
{
    int i = 0;
    while (i < all->n && all->candidate[i] != candidate) i++;
    if (i == MUKCA_MAX_ACCEPTED) return 0;
    all->candidate[i] = candidate;
    if (i == all->n) all->scale[all->n++] = scale;
    return UINT64_C(1) << i;
}

static void select_causes(naming *all, uint64_t in, double weight)
{
    int i = 0;
    while (i < all->n_selections && all->list[i].in != in) i++;
    if (i == MOST) return;
    if (i == all->n_selections) all->list[all->n_selections++] = (selection){.in = in};
    all->list[i].weight += weight;
}

MUKCA_FALLING(by_weight, selection, weight)

/* Leave out improbable causes and selections. */
static void thin(naming *all)
{
    const int n = all->n_selections;
    uint64_t probable = 0;
    for (int i = 0; i < all->n; i++)
        if (all->weight[i] >= NEGLIGIBLE) probable |= UINT64_C(1) << i;
    all->n_selections = 0;
    for (int i = 0; i < n; i++) /* in place: there are no more of them */
        select_causes(all, all->list[i].in & probable, all->list[i].weight);
    qsort(all->list, (size_t)all->n_selections, sizeof *all->list, by_weight);
    while (all->n_selections > 1 && (all->n_selections > MUKCA_MOST_MODELS ||
                                     all->list[all->n_selections - 1].weight < NEGLIGIBLE))
        all->n_selections--;
}

/* The causes of the unknowns: faults as they are, and those that are named; the models. */
static bool set_models(mukca_unknowns *u, const naming *all)
{
    uint64_t faults = 0, into[MUKCA_MAX_ACCEPTED] = {0};
    double sum = 0;
    bool complete = true; /* does every cause remain? */
    for (int c = u->n_causes - 1; c >= 0; c--) {
        const mukca_candidate *h = &u->cause[c].candidate;
        if (mukca_candidate_is_fault(h)) continue;
        complete &= is_named(all, h);
        mukca_unknowns_drop(u, c);
    }
    for (int c = 0; c < u->n_causes; c++) faults |= UINT64_C(1) << c;
    for (int i = 0; i < all->n; i++) {
        bool used = false;
        for (int k = 0; k < all->n_selections; k++) used |= all->list[k].in >> i & 1;
        if (!used || !mukca_unknowns_add(u, &all->search->all.list[all->candidate[i]])) continue;
        mukca_accepted *cause = &u->cause[u->n_causes - 1];
        cause->scale = all->scale[i];
        cause->sized = true;
        into[i] = UINT64_C(1) << (u->n_causes - 1);
    }
    for (int k = 0; k < all->n_selections; k++) {
        u->model[k] = faults;
        for (int i = 0; i < all->n; i++)
            if (all->list[k].in >> i & 1) u->model[k] |= into[i];
        sum += all->list[k].weight;
    }
    for (int k = 0; k < all->n_selections; k++) u->model_weight[k] = all->list[k].weight / sum;
    u->n_models = all->n_selections;
    return complete;
}

/* Drop the causes that cannot be negative, but are: others may turn a sign. */
static bool drop_negative(mukca_unknowns *u)
{
    const int before = u->n_causes;
    for (int c = before - 1; c >= 0; c--) {
        const int class = mukca_candidate_class(&u->cause[c].candidate);
        if (class < MUKCA_EFFECT_COUNT && mukca_effect_table[class]->nonnegative &&
            !(u->cause[c].coefficient[0] > 0))
            mukca_unknowns_drop(u, c);
    }
    return u->n_causes < before;
}

static void fit(mukca_regression *m, const mukca_search *search, bool every)
{
    naming *all = MUKCA_TAKE(&m->pool, naming, 1);
    if (!all) return; /* the pool keeps the failure */
    all->search = search;
    all->every = every;
    for (int s = 0; s < search->n_sets; s++) {
        const mukca_causes *set = &search->set[s];
        uint64_t in = 0;
        for (int k = 0; k < set->n; k++)
            if (is_named(all, &search->all.list[set->candidate[k]]))
                in |= bit_of(all, set->candidate[k], set->scale[k]);
        for (int i = 0; i < all->n; i++)
            if (in >> i & 1) all->weight[i] += set->weight;
        select_causes(all, in, set->weight);
    }
    thin(all);
    const bool complete = set_models(&m->unknowns, all);
    do mukca_regression_fit(m, 4, complete ? MUKCA_FIT_UNKNOWNS : MUKCA_FIT_INDEPENDENT);
    while (drop_negative(&m->unknowns));
    mukca_regression_linearise(m);
}

mukca_status mukca_averaged_fit(mukca_regression *m, mukca_search *search, mukca_error *error)
{
    mukca_shrink gain = {0};
    mukca_unknowns kept;
    mukca_folds b = {.m = m};
    double *before = MUKCA_TAKE(&m->pool, double, m->recording.data->n_rows);
    fit(m, search, false);
    if (search->options->no_folds || search->diagnosis->verdict == MUKCA_VERDICT_NONE)
        return MUKCA_OK;
    mukca_folds_create(&b);
    if (m->pool.failed || mukca_folds_assign(b.fold, m, false) < 2 ||
        !mukca_unknowns_clone(&kept, &m->pool, &m->unknowns))
        return MUKCA_OK; /* the pool keeps a failure */
    mukca_folds_run(before, &b, false);
    if (mukca_verdict_probability(search, MUKCA_CLASS_UNKNOWN) >= NEGLIGIBLE) {
        MUKCA_TRY(mukca_identify_listed(search, error));
        mukca_identify_settle(search);
    }
    fit(m, search, true);
    mukca_folds_run(b.error, &b, false);
    mukca_folds_compare(&gain, &b, before, b.error);
    if (gain.low_percent > 0 && gain.folds_better >= CONSISTENT * gain.folds) return MUKCA_OK;
    mukca_unknowns_assign(&m->unknowns, &kept);
    mukca_regression_linearise(m);
    return MUKCA_OK;
}
