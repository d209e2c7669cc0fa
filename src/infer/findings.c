/* Findings from a posterior over sets of causes: groups, and the choice among them. */
#include "infer/findings.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "infer/sets.h"

/* Coarseness of a kind of group in addition to positions times kinds of causes: it decides between
 * groups with the same causes. */
static const double coarser[] = {0, 0.01, 0.2, 0.4, 0.6},
                    coarser_stretch[] = {0.49, 0.5, 0.3, 0.6, 0.9};

typedef struct {
    mukca_finding_group group;
    double coarseness;
} ranked;

typedef struct {
    const mukca_labelled_sets *posterior;
    const mukca_labelled_sets *half; /* [n_halves] */
    int n_halves;
    double *present; /* [n_labels] probability of a label in the whole */
    ranked *list;    /* NULL: count only */
    int n;
} groups;

/* Whether a cause is one of a group's, or of a finer group's that was chosen before it. */
static bool covers(const mukca_finding_group *g, const mukca_label *l)
{
    if (g->kind == MUKCA_GROUP_TIE && (l->tie != g->tie || l->apart)) return l->tie == g->tie;
    if (l->from < g->from || l->to > g->to || l->apart != g->apart) return false;
    switch (g->kind) {
        case MUKCA_GROUP_DETAIL:
            return l->effect == g->effect && l->detail >= g->low && l->detail <= g->high;
        case MUKCA_GROUP_EFFECT:
            return l->effect == g->effect;
        case MUKCA_GROUP_FAMILY:
            return l->family == g->family;
        default: /* a tie, and a place */
            return true;
    }
}

bool mukca_finding_holds(const mukca_finding_group *g, const mukca_label *l)
{
    bool holds = covers(g, l);
    for (int i = 0; i < g->n_finer && holds; i++) holds = !covers(&g->finer[i], l);
    return holds;
}

int mukca_label_number(mukca_label *labels, int *n, const mukca_label *label)
{
    int k = 0;
    for (const mukca_label *l = labels; k < *n; l++, k++)
        if (l->family == label->family && l->effect == label->effect && l->from == label->from &&
            l->to == label->to && l->detail == label->detail && l->apart == label->apart)
            return k;
    labels[(*n)++] = *label;
    return k;
}

/* Part of a group's probability with a detail below this one. */
static double details_below(const mukca_finding_group *g, const mukca_labelled_sets *p,
                            const double *probability, int detail)
{
    double below = 0, total = 0;
    for (int l = 0; l < p->n_labels; l++) {
        if (!mukca_finding_holds(g, &p->label[l])) continue;
        total += probability[l];
        if (p->label[l].detail < detail) below += probability[l];
    }
    return total > 0 ? below / total : 1;
}

void mukca_finding_details(int range[2], const mukca_finding_group *g, const mukca_labelled_sets *p,
                           const double *probability)
{
    for (int l = 0; l < p->n_labels; l++) {
        const int detail = p->label[l].detail;
        if (!mukca_finding_holds(g, &p->label[l]) || !detail) continue;
        const double below = details_below(g, p, probability, detail),
                     upto = details_below(g, p, probability, detail + 1);
        if (below <= 0.025 && upto > 0.025) range[0] = detail;
        if (below < 0.975 && upto >= 0.975) range[1] = detail;
    }
}

mukca_finding_group mukca_finding_alone(const mukca_label *l)
{
    return (mukca_finding_group){.kind = l->detail ? MUKCA_GROUP_DETAIL : MUKCA_GROUP_EFFECT,
                                 .family = l->family,
                                 .effect = l->effect,
                                 .tie = l->tie,
                                 .from = l->from,
                                 .to = l->to,
                                 .low = l->detail - l->blur,
                                 .high = l->detail + l->blur,
                                 .fine = l->fine,
                                 .apart = l->apart};
}

/* Whether a cause shows in data in which the group does. */
static bool overlaps(const mukca_finding_group *g, const mukca_label *l,
                     const mukca_labelled_sets *p)
{
    return !p->separate || g->tie || l->tie || g->apart || l->apart ||
           (l->from <= g->to && l->to >= g->from);
}

/* Square that the members of a set which are in the group explain together, (*split) the same with
 * half of their products with the others, and (*outside) the largest square of another member
 * outside the catalogue in the same data. */
static double square_of(double *split, double *outside, const mukca_finding_group *g,
                        const mukca_labelled_set *s, const mukca_labelled_sets *p)
{
    double square = 0;
    bool in[MUKCA_SET_ITEMS];
    *split = *outside = 0;
    for (int i = 0; i < s->n; i++) {
        const mukca_label *l = &p->label[s->label[i]];
        in[i] = mukca_finding_holds(g, l);
        if (!in[i] && l->effect < 0 && overlaps(g, l, p))
            *outside = fmax(*outside, s->product[i * s->n + i]);
    }
    for (int i = 0; i < s->n; i++)
        for (int k = 0; k < s->n && in[i]; k++) {
            *split += s->product[i * s->n + k];
            if (in[k]) square += s->product[i * s->n + k];
        }
    return square;
}

/* Probability of a cause that is in a set and not in the group, where both show in the same data,
 * and that the whole does not have: present[n_labels] is the probability of each label there. */
static double rival_of(const mukca_finding_group *g, const mukca_labelled_set *s,
                       const mukca_labelled_sets *p, const double *present)
{
    double rival = 0;
    for (int k = 0; k < s->n; k++) {
        const mukca_label *l = &p->label[s->label[k]];
        if (!mukca_finding_holds(g, l) && overlaps(g, l, p) && s->product[k * s->n + k] > p->least)
            rival = fmax(rival, 1 - present[s->label[k]]);
    }
    return rival;
}

/* Does the group name an effect?  A fine function is no part of a cause outside the catalogue. */
static bool is_name(const mukca_finding_group *g)
{
    return g->kind <= MUKCA_GROUP_EFFECT && !(g->kind == MUKCA_GROUP_DETAIL && g->fine);
}

/* Probability of a group; *against: of a rival in the sets without it (present NULL: not asked).
 * A name beside a cause outside the catalogue may be what the function in its place does not
 * follow. That is a fraction of it: if every fraction is equally probable, it is smaller than the
 * name's part of the amplitude of both with that part as probability. */
static double weigh(double *against, const mukca_finding_group *g, const mukca_labelled_sets *p,
                    const double *present)
{
    const bool name = is_name(g);
    double sum = 0, split, outside;
    for (int i = 0; i < p->n_sets; i++) {
        const double square = square_of(&split, &outside, g, &p->set[i], p);
        if (square > p->least)
            sum += p->set[i].weight * (name ? sqrt(square / (square + outside)) : 1);
        else if (present)
            *against += p->set[i].weight * rival_of(g, &p->set[i], p, present);
    }
    return fmin(sum, 1);
}

double mukca_finding_probability(const mukca_finding_group *g, const mukca_labelled_sets *p)
{
    return weigh(NULL, g, p, NULL);
}

void mukca_labels_weigh(double *probability, const mukca_labelled_sets *p)
{
    for (int i = 0; i < p->n_sets; i++)
        for (int k = 0; k < p->set[i].n; k++) {
            const unsigned short *label = p->set[i].label;
            bool counted = false;
            for (int o = 0; o < k && !counted; o++) counted = label[o] == label[k];
            if (!counted) probability[label[k]] += p->set[i].weight;
        }
}

double mukca_finding_share(const mukca_finding_group *g, const mukca_labelled_sets *p)
{
    double part = 0, whole = 0;
    for (int i = 0; i < p->n_sets; i++) {
        const mukca_labelled_set *s = &p->set[i];
        double split, outside;
        square_of(&split, &outside, g, s, p);
        part += s->weight * split;
        for (int k = 0; k < s->n * s->n; k++) whole += s->weight * s->product[k];
    }
    return whole > 0 ? part / whole : 0;
}

/* Positions times kinds of causes. */
static double coarseness_of(const mukca_finding_group *g, const mukca_labelled_sets *p)
{
    int span = g->to - g->from + 1, least = span, kinds = 0;
    for (int l = 0; l < p->n_labels; l++) {
        bool repeated = false;
        if (!mukca_finding_holds(g, &p->label[l])) continue;
        const int extent = p->label[l].to - p->label[l].from;
        least = extent < least ? extent : least;
        for (int o = 0; o < l && !repeated; o++)
            repeated = mukca_finding_holds(g, &p->label[o]) &&
                       (p->label[o].effect == p->label[l].effect ||
                        (p->label[o].effect < 0 && p->label[l].effect < 0));
        kinds += !repeated;
    }
    span -= least; /* an effect of all joints is at one place */
    return span * kinds + (span > 1 ? coarser_stretch : coarser)[g->kind];
}

static void add(groups *all, mukca_finding_group group)
{
    if (all->list) all->list[all->n] = (ranked){.group = group};
    all->n++;
}

/* Add the groups of a kind for each stretch between positions of the causes like this one, if it is
 * the first of these. */
static void add_stretches(groups *all, mukca_group_kind kind, int label)
{
    const mukca_label *l = all->posterior->label;
    const int n = all->posterior->n_labels;
    const mukca_finding_group like = {.kind = kind,
                                      .family = kind < MUKCA_GROUP_TIE ? l[label].family : -1,
                                      .tie = l[label].tie,
                                      .effect = kind == MUKCA_GROUP_EFFECT ? l[label].effect : -1,
                                      .from = -1000,
                                      .to = 1000,
                                      .apart = l[label].apart};
    for (int o = 0; o < label; o++)
        if (mukca_finding_holds(&like, &l[o]) && l[o].apart == like.apart) return;
    for (int a = 0; a < n; a++) {
        bool repeated = !mukca_finding_holds(&like, &l[a]) || l[a].apart != like.apart;
        for (int o = 0; o < a && !repeated; o++)
            repeated = mukca_finding_holds(&like, &l[o]) && l[o].from == l[a].from;
        for (int b = 0; b < n && !repeated; b++) {
            bool known = !mukca_finding_holds(&like, &l[b]) || l[b].to < l[a].from ||
                         l[b].apart != like.apart;
            for (int o = 0; o < b && !known; o++)
                known = mukca_finding_holds(&like, &l[o]) && l[o].to == l[b].to;
            mukca_finding_group g = like;
            g.from = l[a].from, g.to = l[b].to;
            if (!known && (kind != MUKCA_GROUP_PLACE || g.from == g.to)) add(all, g);
        }
    }
}

static void list_groups(groups *all)
{
    all->n = 0;
    for (int i = 0; i < all->posterior->n_labels; i++) {
        const mukca_label *l = &all->posterior->label[i];
        if (l->detail) add(all, mukca_finding_alone(l));
        if (l->effect >= 0) add_stretches(all, MUKCA_GROUP_EFFECT, i);
        add_stretches(all, MUKCA_GROUP_FAMILY, i);
        if (!l->apart && l->tie) add_stretches(all, MUKCA_GROUP_TIE, i);
        if (!l->apart) add_stretches(all, MUKCA_GROUP_PLACE, i);
    }
}

static int by_coarseness(const void *a, const void *b)
{
    const ranked *x = a, *y = b;
    if (x->coarseness != y->coarseness)
        return (x->coarseness > y->coarseness) - (x->coarseness < y->coarseness);
    return (x->group.probability < y->group.probability) -
           (x->group.probability > y->group.probability);
}

static void ask_halves(mukca_finding_group *g, const groups *all)
{
    const int n = all->n_halves;
    g->n_halves = n;
    g->halves = g->against = n ? 0 : NAN;
    for (int h = 0; h < n; h++) g->halves += weigh(&g->against, g, &all->half[h], all->present) / n;
    g->against /= n;
}

/* Expected share of the halves in favour of a group, of those that decide: one that has too few
 * rows for the group, and no rival, says nothing.  Prior: Beta(1/2, 1/2) (Jeffreys). */
static double support(const mukca_finding_group *g)
{
    return (0.5 + g->n_halves * g->halves) / (1 + g->n_halves * (g->halves + g->against));
}

/* Do n chosen groups have some of a group's causes? */
static bool shares(const mukca_finding_group *g, const mukca_finding_group *chosen, int n,
                   const mukca_labelled_sets *p)
{
    bool shared = false;
    for (int l = 0; l < p->n_labels && !shared; l++)
        for (int i = 0; i < n && !shared && covers(g, &p->label[l]); i++)
            shared = covers(&chosen[i], &p->label[l]);
    return shared;
}

/* Does the group name an effect, in these or other words?  What causes vary with says no more than
 * the name of one of them that is as sure as a finding. */
static bool says_name(const mukca_finding_group *g, const groups *all)
{
    bool found = is_name(g);
    for (int i = 0; i < all->posterior->n_labels && !found; i++) {
        const mukca_label *l = &all->posterior->label[i];
        found = g->kind == MUKCA_GROUP_FAMILY && l->effect >= 0 && !l->fine &&
                all->present[i] >= MUKCA_FINDING_SURE && mukca_finding_holds(g, l);
    }
    return found;
}

static bool is_sure(const mukca_finding_group *g, const groups *all)
{
    return g->probability >= (says_name(g, all) ? MUKCA_FINDING_NAMED : MUKCA_FINDING_SURE) &&
           support(g) > MUKCA_FINDING_STABLE;
}

/* Does a group explain more than each of the n finer ones, which have some of its causes?  Less may
 * be what the function of the other's cause does not follow. */
static bool is_larger(const mukca_finding_group *g, const mukca_finding_group *finer, int n,
                      const mukca_labelled_sets *p)
{
    bool larger = true;
    for (int i = 0; i < n && larger; i++)
        larger = !shares(g, &finer[i], 1, p) ||
                 mukca_finding_share(g, p) > mukca_finding_share(&finer[i], p);
    return larger;
}

/* Append to out[n] the finest groups that are sure, each with the causes that those before it have
 * left, or those that may be and share none; returns the new n. */
static int take(mukca_finding_group *out, int n, const groups *all, bool sure)
{
    const int most = n + MUKCA_MOST_FINDINGS;
    for (int k = 0; k < all->n && n < most; k++) {
        mukca_finding_group g = all->list[k].group;
        if (sure && g.probability < MUKCA_FINDING_SURE) continue; /* nor would fewer causes be */
        const bool shared = shares(&g, out, n, all->posterior);
        if (shared && !sure) continue;
        if (shared) {
            g.finer = out, g.n_finer = n;
            g.probability = mukca_finding_probability(&g, all->posterior);
            ask_halves(&g, all);
        }
        if (sure && !is_sure(&g, all)) continue;
        if (shared && !is_larger(&g, out, n, all->posterior)) continue;
        /* what is no finding is as probable as the whole and its halves say on average */
        if (!sure) g.probability = 0.5 * (g.probability + (isnan(g.halves) ? 0.5 : g.halves));
        if (g.probability >= MUKCA_FINDING_MAYBE) out[n++] = g;
    }
    return n;
}

int mukca_findings_choose(mukca_finding_group out[2 * MUKCA_MOST_FINDINGS], int *n_findings,
                          mukca_pool *pool, const mukca_labelled_sets *posterior,
                          const mukca_labelled_sets *halves, int n_halves)
{
    groups all = {.posterior = posterior, .half = halves, .n_halves = n_halves};
    int kept = 0;
    list_groups(&all);
    all.list = MUKCA_TAKE(pool, ranked, all.n + 1);
    all.present = MUKCA_TAKE(pool, double, posterior->n_labels + 1);
    if (pool->failed) return -1;
    mukca_labels_weigh(all.present, posterior);
    list_groups(&all);
    for (int i = 0; i < all.n; i++) {
        ranked r = all.list[i];
        r.group.probability = mukca_finding_probability(&r.group, posterior);
        if (!(r.group.probability >= MUKCA_FINDING_MAYBE)) continue;
        r.coarseness = coarseness_of(&r.group, posterior);
        ask_halves(&r.group, &all);
        all.list[kept++] = r;
    }
    all.n = kept;
    qsort(all.list, (size_t)all.n, sizeof *all.list, by_coarseness);
    *n_findings = take(out, 0, &all, true);
    return take(out, *n_findings, &all, false);
}
