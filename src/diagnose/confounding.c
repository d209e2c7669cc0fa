/* Canonical correlations among causes and close candidates, after geometry is projected out. */
#include "diagnose/confounding.h"

#include <math.h>
#include <string.h>

#include "diagnose/correlation.h"

/* Correlation from which a candidate is close to a cause: it explains half of the cause's variance,
 * r^2 = 1/2. */
#define CLOSE 0.7071

typedef struct {
    mukca_projector *projector;
    mukca_competition *contest;
    mukca_confounding *out;
    const mukca_candidate *item[MUKCA_MAX_CONFOUNDED];
} confounding_table;

/* Candidate of an effect: an accepted one, else one of the list; NULL: none. */
static const mukca_candidate *find(const mukca_competition *contest, const mukca_effect *effect)
{
    const mukca_candidate key = {.kind = MUKCA_CANDIDATE_EFFECT,
                                 .joint = effect->joint,
                                 .placement = effect->placement,
                                 .effect = *effect};
    const mukca_unknowns *unknowns = &contest->m->unknowns;
    for (int c = 0; c < unknowns->n_causes; c++)
        if (mukca_candidate_same(&unknowns->cause[c].candidate, &key))
            return &unknowns->cause[c].candidate;
    for (int k = 0; k < contest->scan->n_scores; k++) {
        const mukca_candidate *candidate = mukca_scan_candidate(contest->scan, k);
        if (mukca_candidate_same(candidate, &key)) return candidate;
    }
    return NULL;
}

/* Append a candidate unless the table contains it. */
static void add(confounding_table *t, const mukca_candidate *candidate, bool cause)
{
    mukca_confounding *out = t->out;
    if (!candidate || candidate->kind != MUKCA_CANDIDATE_EFFECT || out->n == MUKCA_MAX_CONFOUNDED)
        return;
    for (int i = 0; i < out->n; i++)
        if (mukca_candidate_same(t->item[i], candidate)) return;
    t->item[out->n] = candidate;
    out->effects[out->n] = mukca_candidate_effect(candidate);
    out->cause[out->n++] = cause;
}

/* Candidate of another effect or joint with the highest correlation with a cause; NULL: none is
 * close. */
static const mukca_candidate *closest(confounding_table *t, const mukca_candidate *cause)
{
    const mukca_candidate *best = NULL;
    double most = CLOSE;
    for (int i = 0; cause && i < t->contest->n_first; i++) {
        const mukca_contender *c = &t->contest->first[i];
        const mukca_candidate *candidate = mukca_scan_candidate(t->contest->scan, c->best);
        if (candidate->kind != MUKCA_CANDIDATE_EFFECT ||
            (mukca_candidate_class(candidate) == mukca_candidate_class(cause) &&
             candidate->joint == cause->joint))
            continue;
        const double correlation = mukca_correlation_canonical(t->projector, cause, candidate);
        if (correlation > most) most = correlation, best = candidate;
    }
    return best;
}

void mukca_confounding_measure(mukca_confounding *out, const mukca_findings *findings,
                               mukca_competition *contest)
{
    mukca_regression *m = contest->m;
    mukca_unknowns *unknowns = &m->unknowns;
    confounding_table t = {.contest = contest, .out = out, .projector = &contest->scan->projector};
    const int geometry = mukca_unknowns_column(unknowns, 0),
              all = mukca_unknowns_column(unknowns, unknowns->n_causes);
    mukca_unknowns_prior(m->evidence.prior, unknowns);
    /* a prior sigma of 0 excludes a column: here all causes */
    memset(m->evidence.prior + geometry, 0, sizeof *m->evidence.prior * (size_t)(all - geometry));
    mukca_projector_aim(t.projector, mukca_regression_collect_own(m), unknowns->sigma);
    for (int i = 0; i < findings->n_causes; i++)
        add(&t, find(contest, &findings->causes[i].effect), true);
    const int causes = t.out->n;
    for (int i = 0; i < findings->n_causes; i++)
        for (int k = 0; k < findings->causes[i].n_ties; k++)
            add(&t, find(contest, &findings->causes[i].ties[k].rival), false);
    for (int i = 0; i < causes; i++) add(&t, closest(&t, t.item[i]), false);
    for (int i = 0; i < t.out->n; i++) {
        t.out->correlation[i][i] = 1;
        for (int k = 0; k < i; k++)
            t.out->correlation[i][k] = t.out->correlation[k][i] =
                mukca_correlation_canonical(t.projector, t.item[i], t.item[k]);
    }
    mukca_unknowns_prior(m->evidence.prior, unknowns);
    mukca_regression_factor(m);
}
