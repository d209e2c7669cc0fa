/* Sizes of findings: displacement of the tip, coefficient, alternatives, each averaged over sets.
 *
 * In a set the coefficients c of a group's members are Gaussian, and its displacement has the
 * square c'G c, with G of the plain displacements that the geometry does not absorb.  Its first two
 * moments (A. Mathai, S. Provost, Quadratic Forms in Random Variables, 1992, section 3.2) give mean
 * and deviation of the root, as of a Gaussian with the same second and fourth moments.  Over sets
 * these are mixed with the sets' weights, so that an interval contains what no set is sure of. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "diagnose/findings.h"
#include "infer/gaussians.h"
#include "math/dense.h"
#include "math/stats.h"

/* Probability of the sets that are averaged. */
#define AVERAGED 0.99
/* Least square of the correlation with the column of one member at which all act through one
 * quantity. */
#define ONE_QUANTITY 0.9
/* Least probability of an alternative. */
#define ALTERNATIVE 0.05

typedef struct {
    mukca_search *search;
    const mukca_labelled_search *in;
    mukca_question plain; /* independent noise: products are those of displacements */
    mukca_sets plain_sets;
    int *plain_of; /* [n_kept] item of it, -1: none */
    /* the present set */
    const mukca_set *set;
    int columns, at[MUKCA_SET_ITEMS];
    double mean[MUKCA_SET_COLUMNS], *V, *G; /* V, G [columns][columns] */
    double *product;                        /* scratch [3][columns][columns] */
} measured;

/* Means, covariance and plain products of a set's columns. */
static bool take_set(measured *w, const mukca_set *set, double *scratch)
{
    const mukca_search *search = w->search;
    mukca_sets *sets = &w->search->sets;
    double *block = search->scan.batch->scratch->B;
    mukca_sets_mean(scratch, sets, set);
    w->set = set;
    w->columns = mukca_sets_covariance(w->V, sets);
    for (int m = 0, row = 0; m < set->n; m++) {
        const mukca_item *h = &search->question.item[set->item[m]];
        w->at[m] = row;
        for (int t = 0; t < h->terms; t++) w->mean[row++] = scratch[h->at + t];
    }
    for (int a = 0; a < set->n; a++)
        for (int b = 0; b < set->n; b++) {
            const int x = w->plain_of[set->item[a]], y = w->plain_of[set->item[b]];
            const int ka = w->plain.item[x].terms, kb = w->plain.item[y].terms;
            mukca_sets_products_of(block, &w->plain_sets, x, y);
            for (int i = 0; i < ka; i++)
                memcpy(w->G + (w->at[a] + i) * w->columns + w->at[b], block + i * kb,
                       sizeof *block * (size_t)kb);
        }
    return !w->plain_sets.pool->failed;
}

/* Columns of the set's members with these labels, index[]; returns their number. */
static int columns_of(int *index, const measured *w, const mukca_finding_group *g, int label)
{
    const mukca_label *l = w->in->posterior.label;
    int n = 0;
    for (int m = 0; m < w->set->n; m++) {
        const int member = w->in->label_of[w->set->item[m]];
        if (member < 0 || (label >= 0 ? member != label : !mukca_finding_holds(g, &l[member])))
            continue;
        for (int t = 0; t < w->search->question.item[w->set->item[m]].terms; t++)
            index[n++] = w->at[m] + t;
    }
    return n;
}

/* out[n][n]: rows and columns index[n] of a matrix of the set's columns. */
static void pick(double *out, const double *from, const measured *w, const int *index, int n)
{
    for (int a = 0; a < n; a++)
        for (int b = 0; b < n; b++) out[a * n + b] = from[index[a] * w->columns + index[b]];
}

/* Add the root of the square that some columns explain. */
static void add_size(mukca_gaussians *out, measured *w, const int *index, int n, double weight)
{
    double *M = w->product, *G = M + n * n, *V = G + n * n, square = 0, variance = 0, trace = 0;
    pick(G, w->G, w, index, n);
    pick(V, w->V, w, index, n);
    memset(M, 0, sizeof *M * (size_t)(n * n));
    mukca_dense_xty(M, (mukca_columns){G, n, n}, (mukca_columns){V, n, n}, n); /* G is symmetric */
    for (int a = 0; a < n; a++) {
        double along = 0, Gm = 0; /* m'G V, and G m */
        for (int b = 0; b < n; b++) {
            trace += M[a * n + b] * M[b * n + a];
            along += w->mean[index[b]] * M[b * n + a];
            Gm += G[a * n + b] * w->mean[index[b]];
        }
        square += w->mean[index[a]] * Gm + M[a * n + a];
        variance += 4 * along * Gm;
    }
    variance += 2 * trace;
    const double fourth =
        sqrt(fmax(square * square - 0.5 * variance, 0)); /* mean of root, squared */
    mukca_gaussians_add(out, sqrt(fourth), square - fourth, weight);
}

/* Add the regression of what the columns displace on the column of an item of the last search;
 * returns the square of the correlation.  Of an elastic effect it is the coefficient by the masses
 * of the model; the true one differs by their errors, which a single effect hardly shows.  The
 * columns for these have the masses' prior deviations as their units. */
static double add_coefficient(mukca_gaussians *out, measured *w, const int *index, int n, int item,
                              double weight)
{
    const mukca_candidate *h = &w->search->all.list[w->search->kept[item]];
    const int reference = w->plain_of[item];
    double *block = w->search->scan.batch->scratch->B, part[MUKCA_SET_COLUMNS] = {0},
           square_of_column, by_body[MUKCA_MOST_TERMS] = {0}, mean = 0, variance = 0, square = 0;
    mukca_sets_products_of(block, &w->plain_sets, reference, reference);
    square_of_column = fmax(block[0], 1e-30);
    for (int m = 0; m < w->set->n; m++) {
        const int x = w->plain_of[w->set->item[m]], terms = w->plain.item[x].terms,
                  own = mukca_candidate_own_terms(
                      &w->search->all.list[w->search->kept[w->set->item[m]]]);
        mukca_sets_products_of(block, &w->plain_sets, reference, x);
        int first = -1; /* the group's own columns of this member */
        for (int i = 0; i < n; i++)
            if (index[i] >= w->at[m] && index[i] < w->at[m] + terms) {
                const int t = index[i] - w->at[m];
                if (t == 0) first = i;
                part[i] = block[t] / square_of_column;
                if (first >= 0 && t >= own) by_body[t - own] += part[i] * w->mean[index[first]];
            }
    }
    for (int b = 0; b < MUKCA_MOST_TERMS; b++) variance += by_body[b] * by_body[b];
    for (int i = 0; i < n; i++) {
        mean += part[i] * w->mean[index[i]];
        for (int k = 0; k < n; k++) {
            variance += part[i] * part[k] * w->V[index[i] * w->columns + index[k]];
            square +=
                w->mean[index[i]] * w->mean[index[k]] * w->G[index[i] * w->columns + index[k]];
        }
    }
    mukca_gaussians_add(out, mean / h->unit[0], variance / (h->unit[0] * h->unit[0]), weight);
    return square > 0 ? mean * mean * square_of_column / square : 0;
}

/* Add the root of the squared coefficients of an effect with several. */
static void add_norm(mukca_gaussians *out, const measured *w, const int *index,
                     const mukca_candidate *h, double weight)
{
    const int terms = mukca_candidate_own_terms(h);
    double square = 0, variance = 0;
    for (int t = 0; t < terms; t++) square += pow(w->mean[index[t]] / h->unit[t], 2);
    for (int t = 0; t < terms && square > 0; t++)
        for (int k = 0; k < terms; k++)
            variance += w->mean[index[t]] * w->mean[index[k]] *
                        w->V[index[t] * w->columns + index[k]] /
                        (pow(h->unit[t] * h->unit[k], 2) * square);
    mukca_gaussians_add(out, sqrt(square), variance, weight);
}

/* ---- alternatives ---- */

MUKCA_FALLING(by_probability, mukca_alternative, probability)

/* Probability of each label, and its most probable candidate. */
static void weigh_labels(double *probability, int *item, double *best, const measured *w)
{
    const mukca_search *search = w->search;
    const mukca_labelled_sets *p = &w->in->posterior;
    mukca_labels_weigh(probability, p);
    for (int s = 0; s < p->n_sets; s++) {
        const mukca_set *set = &search->sets.set[search->set[s].index];
        for (int m = 0; m < set->n; m++) best[set->item[m]] += p->set[s].weight;
    }
    for (int i = 0; i < search->n_kept; i++) {
        const int label = w->in->label_of[i];
        if (label >= 0 && (item[label] < 0 || best[i] > best[item[label]])) item[label] = i;
    }
}

/* ---- all groups ---- */

typedef struct {
    double *probability, *best, *scratch;
    int *item;
    mukca_gaussians *size, *coefficient,
        *amplitude; /* of groups, the last size of all; of labels */
    double fit[2 * MUKCA_MOST_FINDINGS], weight[2 * MUKCA_MOST_FINDINGS];
} tables;

static mukca_finding *finding_at(mukca_diagnosis *d, int i)
{
    return i < d->n_findings ? &d->findings[i] : &d->maybe[i - d->n_findings];
}

/* Time constants of the members that change with time. */
static void find_time_constants(double range[2], const mukca_finding_group *g, const measured *w,
                                const tables *t)
{
    double low = HUGE_VAL, high = 0;
    for (int i = 0; i < w->search->n_kept; i++) {
        const mukca_candidate *h = &w->search->all.list[w->search->kept[i]];
        const int label = w->in->label_of[i];
        if (label < 0 || !(t->best[i] >= ALTERNATIVE) ||
            !mukca_finding_holds(g, &w->in->posterior.label[label]))
            continue;
        const double constant = h->effect.variant.time_constant;
        low = fmin(low, constant > 0 ? constant : HUGE_VAL);
        high = fmax(high, constant > 0 ? constant : HUGE_VAL);
    }
    if (high > 0) range[0] = low, range[1] = high;
}

static void describe(mukca_finding *f, const measured *w, const tables *t)
{
    const mukca_labelled_sets *p = &w->in->posterior;
    mukca_alternative all[64] = {0};
    double outside = 0, inside = 0;
    int n = 0;
    for (int i = 0; i < p->n_labels; i++) {
        const mukca_label *l = &p->label[i];
        if (!mukca_finding_holds(&f->group, l)) continue;
        *(l->effect < 0 ? &outside : &inside) += t->probability[i];
        if (t->item[i] < 0 || !(t->probability[i] >= ALTERNATIVE) || n == 64) continue;
        const mukca_candidate *h = &w->search->all.list[w->search->kept[t->item[i]]];
        mukca_alternative *a = &all[n++];
        *a = (mukca_alternative){.effect = mukca_candidate_effect(h),
                                 .listed = l->effect >= 0,
                                 .family = l->family,
                                 .from = l->from,
                                 .to = l->to,
                                 .probability = fmin(t->probability[i], 1),
                                 .amplitude = MUKCA_ESTIMATE_NONE};
        mukca_effect *e = &a->effect;
        if (!a->listed) e->kind = MUKCA_EFFECT_COUNT;
        if (!a->listed) continue;
        const mukca_finding_group alone = mukca_finding_alone(l);
        const bool nonnegative = mukca_effect_table[e->kind]->nonnegative;
        a->probability = fmin(a->probability, mukca_finding_probability(&alone, p));
        a->amplitude = mukca_gaussians_estimate(&t->amplitude[i], 1, nonnegative);
        e->terms = mukca_effect_terms(e);
        for (int c = 0; c < e->terms; c++) e->coefficient[c] = a->amplitude.value / sqrt(e->terms);
    }
    qsort(all, (size_t)n, sizeof *all, by_probability);
    f->n_alternatives = n < MUKCA_MAX_ALTERNATIVES ? n : MUKCA_MAX_ALTERNATIVES;
    memcpy(f->alternatives, all, sizeof *all * (size_t)f->n_alternatives);
    f->outside = outside + inside > 0 ? outside / (outside + inside) : 0;
    f->share = mukca_finding_share(&f->group, p);
    if (f->group.effect >= 0 && mukca_effect_has(f->group.effect, MUKCA_TRAIT_OF_TIME))
        find_time_constants(f->time_constant, &f->group, w, t);
    if (f->group.effect >= 0 && f->group.from == f->group.to &&
        mukca_effect_has(f->group.effect, MUKCA_TRAIT_ORDERS))
        mukca_finding_details(f->order, &f->group, p, t->probability);
}

/* Item whose column is the group's quantity: of its most probable effect, if that has one
 * coefficient; -1: none. */
static int quantity_of(const mukca_finding *f, const measured *w, const tables *t)
{
    const mukca_labelled_sets *p = &w->in->posterior;
    int best = -1;
    for (int l = 0; l < p->n_labels; l++)
        if (t->item[l] >= 0 && mukca_finding_holds(&f->group, &p->label[l]) &&
            (best < 0 || t->probability[l] > t->probability[best]))
            best = l;
    if (best < 0 || p->label[best].effect < 0) return -1;
    const mukca_candidate *h = &w->search->all.list[w->search->kept[t->item[best]]];
    return mukca_candidate_own_terms(h) == 1 && h->kind == MUKCA_CANDIDATE_EFFECT ? t->item[best]
                                                                                  : -1;
}

static void add_all(measured *w, tables *t, mukca_diagnosis *d, double weight)
{
    const mukca_labelled_sets *p = &w->in->posterior;
    int index[MUKCA_SET_COLUMNS];
    for (int i = 0; i < d->n_findings + d->n_maybe; i++) {
        const mukca_finding *f = finding_at(d, i);
        const int columns = columns_of(index, w, &f->group, -1), quantity = quantity_of(f, w, t);
        if (!columns) continue;
        add_size(&t->size[i], w, index, columns, weight);
        if (quantity >= 0)
            t->fit[i] +=
                weight * add_coefficient(&t->coefficient[i], w, index, columns, quantity, weight);
        t->weight[i] += weight;
    }
    const mukca_finding_group whole = {
        .kind = MUKCA_GROUP_PLACE, .from = INT_MIN, .to = INT_MAX, .apart = false};
    int n = columns_of(index, w, &whole, -1);
    mukca_finding_group apart = whole;
    apart.apart = true;
    n += columns_of(index + n, w, &apart, -1);
    add_size(&t->size[d->n_findings + d->n_maybe], w, index, n, weight);
    for (int l = 0; l < p->n_labels; l++) {
        if (t->item[l] < 0 || p->label[l].effect < 0 || !(t->probability[l] >= ALTERNATIVE))
            continue;
        const mukca_candidate *h = &w->search->all.list[w->search->kept[t->item[l]]];
        n = columns_of(index, w, NULL, l);
        if (n && mukca_candidate_own_terms(h) == 1)
            add_coefficient(&t->amplitude[l], w, index, n, t->item[l], weight);
        else if (n)
            add_norm(&t->amplitude[l], w, index, h, weight);
    }
}

/* The plain products of all candidates in the sets. */
static bool make_plain(measured *w, mukca_pool *pool, int n_sets)
{
    mukca_search *search = w->search;
    int *index = MUKCA_TAKE(pool, int, search->n_kept + 1), count = 0;
    unsigned char *used = MUKCA_TAKE(pool, unsigned char, search->n_kept + 1);
    w->plain_of = MUKCA_TAKE(pool, int, search->n_kept + 1);
    if (pool->failed) return false;
    for (int s = 0; s < n_sets; s++)
        for (int m = 0; m < search->set[s].n; m++)
            used[search->sets.set[search->set[s].index].item[m]] = 1;
    for (int i = 0; i < search->n_kept; i++) {
        w->plain_of[i] = used[i] ? count : -1;
        if (used[i]) index[count++] = search->kept[i];
    }
    search->m->unknowns.tails = NULL;
    mukca_evidence_set_share(&search->m->evidence, 0);
    /* without causes: a turned frame that turns a wobble with it absorbs nothing */
    mukca_regression_freeze(search->m);
    return mukca_scan_aim(&search->scan, 0) &&
           mukca_scan_question(&w->plain, &search->scan, pool, index, count) &&
           mukca_scan_leave(&w->plain, &search->scan, pool) &&
           mukca_sets_create(&w->plain_sets, pool, &w->plain);
}

bool mukca_findings_measure(mukca_diagnosis *d, mukca_pool *pool, mukca_search *search,
                            const mukca_labelled_search *in)
{
    const mukca_labelled_sets *p = &in->posterior;
    const int all = d->n_findings + d->n_maybe, square = MUKCA_SET_COLUMNS * MUKCA_SET_COLUMNS;
    if (!all) return true;
    measured w = {.search = search,
                  .in = in,
                  .V = MUKCA_TAKE(pool, double, square),
                  .G = MUKCA_TAKE(pool, double, square),
                  .product = MUKCA_TAKE(pool, double, 3 * square)};
    tables t = {.probability = MUKCA_TAKE(pool, double, p->n_labels + 1),
                .best = MUKCA_TAKE(pool, double, search->n_kept + 1),
                .scratch = MUKCA_TAKE(pool, double, search->question.stride + 1),
                .item = MUKCA_TAKE(pool, int, p->n_labels + 1),
                .size = MUKCA_TAKE(pool, mukca_gaussians, all + 1),
                .coefficient = MUKCA_TAKE(pool, mukca_gaussians, all + 1),
                .amplitude = MUKCA_TAKE(pool, mukca_gaussians, p->n_labels + 1)};
    double sum = 0;
    int n_sets = 0;
    if (pool->failed) return false;
    while (n_sets < p->n_sets && n_sets < MUKCA_MOST_GAUSSIANS && sum < AVERAGED)
        sum += p->set[n_sets++].weight;
    for (int l = 0; l < p->n_labels; l++) t.item[l] = -1;
    weigh_labels(t.probability, t.item, t.best, &w);
    if (!make_plain(&w, pool, n_sets)) return false;
    for (int l = 0; l < p->n_labels; l++)
        if (t.item[l] >= 0 && w.plain_of[t.item[l]] < 0) t.item[l] = -1;
    for (int s = 0; s < n_sets; s++) {
        if (!take_set(&w, &search->sets.set[search->set[s].index], t.scratch)) return false;
        add_all(&w, &t, d, p->set[s].weight);
    }
    const double scale = search->m->unknowns.sigma / sqrt(search->m->recording.n_samples);
    d->caused_m = mukca_gaussians_estimate(&t.size[all], scale, true).value;
    for (int i = 0; i < all; i++) {
        mukca_finding *f = finding_at(d, i);
        describe(f, &w, &t);
        f->size_m = mukca_gaussians_estimate(&t.size[i], scale, true);
        f->coefficient = MUKCA_ESTIMATE_NONE;
        if (t.weight[i] > 0 && t.fit[i] > ONE_QUANTITY * t.weight[i])
            f->coefficient = mukca_gaussians_estimate(&t.coefficient[i], 1, false);
        const int item = quantity_of(f, &w, &t);
        if (item >= 0) f->quantity = mukca_candidate_effect(&search->all.list[search->kept[item]]);
    }
    return true;
}
