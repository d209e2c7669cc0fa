/* Canonical correlations among causes and close candidates, after geometry is projected out. */
#include "diagnose/confounding.h"

#include <math.h>
#include <string.h>

#include "diagnose/cause.h"

/* Correlation from which a candidate is close to a cause: it explains half of the cause's variance,
 * r^2 = 1/2. */
#define CLOSE 0.7071

typedef struct {
    mukca_identification *id;
    mukca_confounding *out;
    int item[MUKCA_MAX_CONFOUNDED]; /* of the last search */
} confounding_table;

static const mukca_candidate *candidate_of(const confounding_table *t, int item)
{
    return &t->id->all.list[t->id->kept[item]];
}

/* Correlation with nothing but the geometry projected out. */
static double correlate(confounding_table *t, int a, int b)
{
    const mukca_set none = {0};
    return mukca_cause_correlation(t->id, &none, a, b);
}

/* Append an effect unless the table contains it. */
static void add(confounding_table *t, int item, bool cause)
{
    mukca_confounding *out = t->out;
    if (item < 0 || candidate_of(t, item)->kind != MUKCA_CANDIDATE_EFFECT ||
        out->n == MUKCA_MAX_CONFOUNDED)
        return;
    for (int i = 0; i < out->n; i++)
        if (t->item[i] == item) return;
    t->item[out->n] = item;
    out->effects[out->n] = mukca_candidate_effect(candidate_of(t, item));
    out->cause[out->n++] = cause;
}

static void add_effect(confounding_table *t, const mukca_effect *effect, bool cause)
{
    const mukca_candidate key = {.kind = MUKCA_CANDIDATE_EFFECT,
                                 .joint = effect->joint,
                                 .placement = effect->placement,
                                 .effect = *effect};
    add(t, mukca_identify_item(t->id, &key), cause);
}

/* Kept candidate of another effect or joint with the highest correlation with a cause; -1: none is
 * close. */
static int closest(confounding_table *t, int cause)
{
    const mukca_candidate *own = candidate_of(t, cause);
    int best = -1;
    double most = CLOSE;
    for (int i = 0; i < t->id->n_kept; i++) {
        const mukca_candidate *h = candidate_of(t, i);
        if (h->kind != MUKCA_CANDIDATE_EFFECT ||
            (mukca_candidate_class(h) == mukca_candidate_class(own) && h->joint == own->joint))
            continue;
        const double correlation = correlate(t, cause, i);
        if (correlation > most) most = correlation, best = i;
    }
    return best;
}

void mukca_confounding_measure(mukca_confounding *out, const mukca_findings *findings,
                               mukca_identification *id)
{
    confounding_table t = {.id = id, .out = out};
    for (int i = 0; i < findings->n_causes; i++)
        if (!findings->causes[i].suspected) add_effect(&t, &findings->causes[i].effect, true);
    const int causes = out->n;
    for (int i = 0; i < findings->n_causes; i++)
        for (int k = 0; k < findings->causes[i].n_ties; k++)
            add_effect(&t, &findings->causes[i].ties[k].rival, false);
    for (int i = 0; i < causes; i++) add(&t, closest(&t, t.item[i]), false);
    for (int i = 0; i < out->n; i++) {
        out->correlation[i][i] = 1;
        for (int k = 0; k < i; k++)
            out->correlation[i][k] = out->correlation[k][i] = correlate(&t, t.item[i], t.item[k]);
    }
}
