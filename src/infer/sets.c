/* Posterior probability of sets of causes. */
#include "infer/given.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/clones.h"

/* Log odds behind the best set beyond which a set is not expanded (20,000 to 1), and behind the
 * best addition beyond which one is not kept. */
#define WINDOW 6.0

enum {
    TABLE = 4 * MUKCA_MOST_SETS,
    VARIANTS = 2, /* sets of the same keys that are expanded */
    ADDED = 40,   /* sets kept of each kind of expansion */
    SWAPPED = 20,
    PAIRED = 10,
    FROM = 3, /* best swaps that are extended by a second item */
    SWEEPS = 3
};

/* Memory to integrate out a set. */
static void take_integral(mukca_sets *s, mukca_pool *pool)
{
    mukca_posterior_take(&s->with.posterior, pool, MUKCA_SET_COLUMNS);
    s->with.inverse = MUKCA_TAKE(pool, double, MUKCA_SET_COLUMNS *MUKCA_SET_COLUMNS);
    s->with.x = MUKCA_TAKE(pool, double, MUKCA_SET_COLUMNS);
}

bool mukca_sets_create(mukca_sets *s, mukca_pool *pool, const mukca_question *q)
{
    int squares = 0;
    for (int i = 0; i < q->n_items; i++) squares += q->item[i].terms * q->item[i].terms;
    *s = (mukca_sets){
        .question = q,
        .pool = pool,
        .block = MUKCA_TAKE(pool, double *, q->n_items + 1),
        .gram = MUKCA_TAKE(pool, const double *, q->n_items + 1),
        .set = MUKCA_TAKE(pool, mukca_set, MUKCA_MOST_SETS),
        .table = MUKCA_TAKE(pool, int, TABLE),
        .alone = MUKCA_TAKE(pool, double, q->n_items + 1),
        .g = MUKCA_TAKE(pool, double, q->stride + 1),
        .given = MUKCA_TAKE(pool, double, squares + 1),
        .left = MUKCA_TAKE(pool, double, MUKCA_GIVEN_TOGETHER *(q->n_rows + MUKCA_SET_COLUMNS)),
        .with.B = MUKCA_TAKE(pool, double, MUKCA_SET_COLUMNS *(q->stride + 1))};
    take_integral(s, pool);
    for (int m = 0; m < MUKCA_SET_ITEMS; m++)
        s->scores[m] = (mukca_scores){MUKCA_TAKE(pool, double, q->n_items + 1),
                                      MUKCA_TAKE(pool, unsigned char, q->n_items + 1)};
    for (int k = 0; k < mukca_workers_count(q->workers); k++) {
        s->worker[k].row = MUKCA_TAKE(pool, double, MUKCA_GIVEN_TOGETHER *(q->stride + 1));
        s->worker[k].mixture = MUKCA_TAKE(pool, mukca_mixture_scratch, 1);
    }
    s->scratch = s->worker[0].mixture;
    double *block = MUKCA_TAKE(pool, double, squares + 1);
    if (pool->failed) return false;
    for (int i = 0; i < q->n_items; block += q->item[i].terms * q->item[i].terms, i++)
        mukca_given_block(s->block[i] = block, s, i);
    mukca_sets_insert(s, NULL, NULL, 0);
    return true;
}

static double square_of(const double *x, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += x[i] * x[i];
    return sum;
}

/* Evidence of a member given the others; by_size as in mukca_mixture_evidence(). */
static double score_member(double *by_size, const mukca_sets *s, const mukca_set *set, int member,
                           mukca_mixture_scratch *f)
{
    const mukca_item *h = &s->question->item[set->item[member]];
    const int k = h->terms;
    double *M = f->A, *G = f->B, *I = f->C, w[MUKCA_MOST_TERMS], g[MUKCA_MOST_TERMS];
    const double size = h->prior.size[set->size[member]];
    if (!mukca_given_leave_out(M, w, s, member, k)) return -HUGE_VAL;
    memset(I, 0, sizeof *I * (size_t)(k * k));
    for (int i = 0; i < k; i++) I[i * k + i] = 1;
    mukca_dense_forward(I, k, M, k);
    memset(G, 0, sizeof *G * (size_t)(k * k));
    mukca_dense_syrk(G, k, I, k, k);
    memcpy(g, w, sizeof *g * (size_t)k);
    mukca_dense_backward(g, 1, M, k);
    for (int i = 0; i < k; i++) {
        G[i * k + i] -= 1;
        g[i] /= size;
    }
    for (int i = 0; i < k * k; i++) G[i] /= size * size;
    return mukca_mixture_evidence(
        by_size, G, g, k, &h->prior,
        fmin(s->with.posterior.quadratic + square_of(w, k), s->question->residual),
        s->question->dof, f);
}

static int largest(const double *x, int n)
{
    int best = 0;
    for (int i = 1; i < n; i++)
        if (x[i] > x[best]) best = i;
    return best;
}

/* Log probability of the signs of all nonnegative items of the set integrated out. */
static double weigh_signs(mukca_sets *s, const mukca_set *set)
{
    double sum = 0, first[MUKCA_SET_COLUMNS];
    for (int m = 0, row = 0; m < set->n; row += s->question->item[set->item[m++]].terms) {
        double mean = 0, variance = 0;
        if (!s->question->item[set->item[m]].prior.nonnegative) continue;
        memset(first, 0, sizeof *first * (size_t)s->with.posterior.n);
        first[row] = 1;
        mukca_dense_forward(first, 1, s->with.posterior.factor, s->with.posterior.n);
        for (int i = row; i < s->with.posterior.n; i++) {
            mean += first[i] * s->with.posterior.work[i];
            variance += first[i] * first[i];
        }
        sum +=
            mukca_mixture_positive(mean, variance, s->with.posterior.quadratic, s->question->dof);
    }
    return sum;
}

/* Log prior of an item in addition to its own, given the first n members of a set. */
static double kinship(const mukca_sets *s, const mukca_set *set, int n, int item)
{
    const mukca_item *h = &s->question->item[item];
    for (int m = 0; m < n && h->kin; m++)
        if (s->question->item[set->item[m]].kin == h->kin) return h->kinship;
    return 0;
}

void mukca_sets_evaluate(mukca_sets *s, int index)
{
    const mukca_question *q = s->question;
    mukca_set *set = &s->set[index];
    double integral = 0;
    bool changed = true;
    if (set->exact) return;
    set->exact = true;
    bool ok = mukca_given_integrate(s, set);
    mukca_given_invert(s);
    for (int sweep = 0; sweep < SWEEPS && changed && ok; sweep++) {
        integral = 0, changed = false;
        for (int m = 0; m < set->n && ok; m++) {
            const mukca_item *h = &q->item[set->item[m]];
            double by_size[MUKCA_MOST_SIZES] = {0};
            const double sum = score_member(by_size, s, set, m, s->scratch);
            const int best = sum > -HUGE_VAL ? largest(by_size, h->prior.n_sizes) : set->size[m];
            integral += sum - by_size[best] + h->prior.log_weight[best];
            if (best == set->size[m]) continue;
            changed = true;
            set->size[m] = (unsigned char)best;
            ok = mukca_given_integrate(s, set);
            mukca_given_invert(s);
        }
    }
    set->value = integral - s->with.posterior.log_det -
                 0.5 * q->dof * log(s->with.posterior.quadratic / q->residual) +
                 weigh_signs(s, set);
    for (int m = 0; m < set->n; m++)
        set->value += q->item[set->item[m]].log_prior + kinship(s, set, m, set->item[m]);
    if (!ok || isnan(set->value)) set->value = -HUGE_VAL;
    if (set->value > s->set[s->best].value) s->best = index;
}

typedef struct {
    mukca_sets *of; /* of each worker: the same sets, with an integral and scratch of its own */
    const int *index;
} evaluating;

static void evaluate_one(void *context, int block, int worker)
{
    const evaluating *job = context;
    mukca_sets_evaluate(&job->of[worker], job->index[block]);
}

bool mukca_sets_evaluate_all(mukca_sets *s, const int *index, int n)
{
    const int workers = mukca_workers_count(s->question->workers);
    evaluating job = {MUKCA_TAKE(s->pool, mukca_sets, workers), index};
    for (int i = 0; i < n; i++) { /* all rows that the workers need */
        const mukca_set *set = &s->set[index[i]];
        for (int m = 0; m < set->n; m++)
            for (int o = 0; o < m; o++)
                if (!s->gram[set->item[m]] && !s->gram[set->item[o]])
                    mukca_given_rows(s, &set->item[m], 1);
    }
    for (int k = 0; k < workers && !s->pool->failed; k++) {
        job.of[k] = *s;
        job.of[k].scratch = s->worker[k].mixture;
        take_integral(&job.of[k], s->pool);
    }
    if (s->pool->failed) return false;
    mukca_workers_run(s->question->workers, n, evaluate_one, &job);
    for (int i = 0; i < n; i++)
        if (s->set[index[i]].value > s->set[s->best].value) s->best = index[i];
    return true;
}

/* FNV-1a (Fowler, Noll, Vo). */
static uint32_t hash(const mukca_set *set)
{
    uint32_t h = 2166136261U;
    for (int i = 0; i < set->n; i++) h = (h ^ set->item[i]) * 16777619U;
    return h ^ h >> 15;
}

/* Index of a set with these members, which is stored if it is new; -1: no room. */
static int find(mukca_sets *s, const mukca_set *set)
{
    uint32_t at = hash(set) % TABLE;
    for (; s->table[at]; at = (at + 1) % TABLE) {
        const mukca_set *other = &s->set[s->table[at] - 1];
        if (other->n == set->n &&
            memcmp(other->item, set->item, sizeof *set->item * (size_t)set->n) == 0)
            return s->table[at] - 1;
    }
    if (s->n_sets == MUKCA_MOST_SETS) return -1;
    s->set[s->n_sets] = *set;
    s->table[at] = ++s->n_sets;
    return s->n_sets - 1;
}

/* Set with another item; false: no room, or its key is in the set. */
static bool extended(mukca_set *out, const mukca_sets *s, const mukca_set *set, int item, int size)
{
    const mukca_item *all = s->question->item;
    int columns = all[item].terms, at = set->n;
    if (set->n == MUKCA_SET_ITEMS) return false;
    for (int i = set->n - 1; i >= 0; i--) {
        if (all[set->item[i]].key == all[item].key) return false;
        columns += all[set->item[i]].terms;
        if (set->item[i] > item) at = i;
    }
    *out = *set;
    out->n++;
    memmove(out->item + at + 1, set->item + at, sizeof *out->item * (size_t)(set->n - at));
    memmove(out->size + at + 1, set->size + at, sizeof *out->size * (size_t)(set->n - at));
    out->item[at] = (unsigned short)item;
    out->size[at] = (unsigned char)size;
    out->exact = out->expanded = out->swapped = false;
    return columns <= MUKCA_SET_COLUMNS;
}

static mukca_set reduced(const mukca_set *set, int member)
{
    mukca_set out = *set;
    out.n--;
    memmove(out.item + member, set->item + member + 1, sizeof *out.item * (size_t)(out.n - member));
    memmove(out.size + member, set->size + member + 1, sizeof *out.size * (size_t)(out.n - member));
    out.exact = out.expanded = out.swapped = false;
    return out;
}

int mukca_sets_insert(mukca_sets *s, const int *item, const double *size, int n)
{
    mukca_set set = {0}, next;
    for (int i = 0; i < n; i++) {
        const mukca_mixture *prior = &s->question->item[item[i]].prior;
        int nearest = size ? 0 : prior->n_sizes / 2;
        for (int k = 1; k < prior->n_sizes && size; k++)
            if (fabs(prior->size[k] - size[i]) < fabs(prior->size[nearest] - size[i])) nearest = k;
        if (!extended(&next, s, &set, item[i], nearest)) return -1;
        set = next;
    }
    if (!mukca_given_rows(s, set.item, set.n)) return -1;
    const int index = find(s, &set);
    if (index >= 0) mukca_sets_evaluate(s, index);
    return index;
}

/* Keep the best of all extensions of a set by their scores, which are overwritten, at most `most`;
 * child[] receives the best `wanted`.  Returns their number. */
static int keep(mukca_sets *s, const mukca_set *set, const mukca_scores *scores, int most,
                int *child, int wanted)
{
    const mukca_question *q = s->question;
    double best = -HUGE_VAL;
    mukca_set next;
    int n = 0;
    for (int taken = 0; taken < most;) {
        const int i = largest(scores->value, q->n_items);
        const double gain = scores->value[i];
        if (!isfinite(gain) || (taken && !(gain > best - WINDOW))) break;
        scores->value[i] = -HUGE_VAL;
        if (!extended(&next, s, set, i, scores->likeliest[i])) continue;
        best = fmax(best, gain);
        next.value = set->value + gain;
        const int at = find(s, &next);
        taken++;
        if (at >= 0 && n < wanted) child[n++] = at;
    }
    return n;
}

/* A member that is left out: k rows W of M^-1 V D G, w = M^-1 x, and the log Bayes factor below
 * which a replacement is of no interest. */
typedef struct {
    int k;
    const double *W;
    double w[MUKCA_MOST_TERMS], least;
} vacancy;

/* Can this item replace the member?  It explains at most (sqrt(a) + sqrt(b))^2, of which a is what
 * it explains beside the member, and b that share of what the member explains, `lost` of the
 * residual `rest`, that is common to the two.  5: more than the cost of any prior size. */
MUKCA_INLINE bool can_replace(const mukca_sets *s, const vacancy *v, const double *given, int item,
                              double lost, double rest)
{
    const mukca_item *h = &s->question->item[item];
    double common = 0;
    for (int a = 0; a < h->terms; a++) {
        double square = 0;
        for (int r = 0; r < v->k; r++) {
            const double x = v->W[r * s->question->stride + h->at + a];
            square += x * x;
        }
        common += square / (given[a * h->terms + a] + square + 1e-300);
    }
    const double beside = fmax(s->alone[item] - h->log_prior + 5, 0),
                 of = -0.5 * s->question->dof * log1p(-fmin(common, 1) * lost / rest);
    return beside + of + 2 * sqrt(beside * of) > v->least;
}

/* Items to be scored in addition to a set: the conditioned one, or that without a member. */
typedef struct {
    mukca_sets *sets;
    const mukca_set *set;
    const vacancy *vacancy; /* NULL: none */
    mukca_scores scores;
} scoring;

MUKCA_CLONES static void score(const scoring *of, int i, mukca_mixture_scratch *f)
{
    const mukca_sets *s = of->sets;
    const mukca_question *q = s->question;
    const mukca_item *h = &q->item[i];
    const vacancy *v = of->vacancy;
    const int terms = h->terms;
    double by_size[MUKCA_MOST_SIZES] = {0}, *G = f->A, g[MUKCA_MOST_TERMS];
    const double *given = mukca_given_of(s, i), lost = v ? square_of(v->w, v->k) : 0,
                 rest = fmin(s->with.posterior.quadratic + lost, q->residual);
    of->scores.value[i] = -HUGE_VAL;
    if (v && !can_replace(s, v, given, i, lost, rest)) return;
    memcpy(G, given, sizeof *G * (size_t)(terms * terms));
    memcpy(g, s->g + h->at, sizeof *g * (size_t)terms);
    for (int r = 0; v && r < v->k; r++) {
        const double *row = v->W + r * q->stride + h->at;
        for (int a = 0; a < terms; a++) {
            g[a] += row[a] * v->w[r];
            for (int c = 0; c < terms; c++) G[a * terms + c] += row[a] * row[c];
        }
    }
    of->scores.value[i] = h->log_prior + kinship(s, of->set, of->set->n, i) +
                          mukca_mixture_evidence(by_size, G, g, terms, &h->prior, rest, q->dof, f);
    of->scores.likeliest[i] = (unsigned char)largest(by_size, h->prior.n_sizes);
}

enum { SCORED = 16 }; /* items in a block */

static void score_block(void *context, int block, int worker)
{
    const scoring *of = context;
    mukca_sets *s = of->sets;
    const int end = (block + 1) * SCORED;
    for (int i = block * SCORED; i < end && i < s->question->n_items; i++) {
        mukca_given_reduce(s, i, s->worker[worker].mixture->D);
        score(of, i, s->worker[worker].mixture);
    }
}

bool mukca_sets_weigh(mukca_sets *s, const mukca_set *set)
{
    const int n = s->question->n_items;
    if (!mukca_given_condition(s, set)) return false;
    scoring of = {s, set, NULL, s->scores[0]};
    mukca_workers_run(s->question->workers, (n + SCORED - 1) / SCORED, score_block, &of);
    memcpy(s->alone, s->scores[0].value, sizeof *s->alone * (size_t)n);
    return true;
}

/* Extend a set by one item. */
static void extend(mukca_sets *s, int index, int most)
{
    const mukca_set set = s->set[index];
    if (mukca_sets_weigh(s, &set)) keep(s, &set, &s->scores[0], most, NULL, 0);
}

/* Number of expanded sets with the same keys. */
static int variants(const mukca_sets *s, const mukca_set *set)
{
    const mukca_item *all = s->question->item;
    int count = 0;
    for (int i = 0; i < s->n_sets; i++) {
        const mukca_set *other = &s->set[i];
        bool same = other->expanded && other->n == set->n;
        for (int a = 0; a < set->n && same; a++) {
            bool found = false;
            for (int b = 0; b < set->n; b++)
                found |= all[set->item[a]].key == all[other->item[b]].key;
            same = found;
        }
        count += same;
    }
    return count;
}

/* The most probable set that is not expanded and swapped; -1: none in the window. */
static int next_open(const mukca_sets *s)
{
    int open = -1;
    for (int i = 0; i < s->n_sets; i++)
        if (!(s->set[i].expanded && s->set[i].swapped) &&
            s->set[i].value > s->set[s->best].value - WINDOW &&
            (open < 0 || s->set[i].value > s->set[open].value))
            open = i;
    return open;
}

typedef struct {
    mukca_sets *sets;
    const mukca_set *set;
    bool pairs;
    struct {
        bool possible;
        double gain; /* evidence of the member given the others */
    } member[MUKCA_SET_ITEMS];
} swapping;

/* Score all items in place of a member. */
static void swap_member(void *context, int m, int worker)
{
    swapping *of = context;
    mukca_sets *s = of->sets;
    const mukca_question *q = s->question;
    const mukca_item *h = &q->item[of->set->item[m]];
    const int at = s->with.at[m];
    double by_size[MUKCA_MOST_SIZES] = {0}, *W = s->worker[worker].row;
    mukca_mixture_scratch *f = s->worker[worker].mixture;
    vacancy v = {.W = W, .k = h->terms};
    of->member[m].possible = mukca_given_leave_out(f->D, v.w, s, m, h->terms);
    if (!of->member[m].possible) return;
    of->member[m].gain = score_member(by_size, s, of->set, m, f);
    memset(W, 0, sizeof *W * (size_t)(h->terms * q->stride)); /* the member's rows of V D G */
    mukca_dense_xty(W, mukca_given_inverse_of(s, m, h->terms),
                    (mukca_columns){s->with.B + at * q->stride, q->stride, q->stride},
                    s->with.posterior.n - at);
    mukca_dense_forward(W, q->stride, f->D, h->terms);
    v.least = of->pairs ? 0 : of->member[m].gain - WINDOW;
    const mukca_set less = reduced(of->set, m);
    const scoring all = {s, &less, &v, s->scores[m]};
    for (int i = 0; i < q->n_items; i++) score(&all, i, f);
}

/* Drop or replace each member of a set; `weighed`: it was extended last; `pairs`: the best
 * replacements are extended, too: one item by two. */
static void swap(mukca_sets *s, int index, bool weighed, bool pairs)
{
    const mukca_set set = s->set[index];
    int child[MUKCA_SET_ITEMS * FROM], n = 0;
    swapping of = {.sets = s, .set = &set, .pairs = pairs};
    if (!set.n || !(weighed || mukca_sets_weigh(s, &set))) return;
    mukca_given_invert(s);
    mukca_workers_run(s->question->workers, set.n, swap_member, &of);
    for (int m = 0; m < set.n; m++) {
        mukca_set less = reduced(&set, m);
        if (!of.member[m].possible) continue;
        less.value = set.value - of.member[m].gain - s->question->item[set.item[m]].log_prior -
                     kinship(s, &less, less.n, set.item[m]);
        if (find(s, &less) < 0) return;
        n += keep(s, &less, &s->scores[m], SWAPPED, child + n, FROM);
    }
    for (int c = 0; c < n && pairs; c++) {
        mukca_sets_evaluate(s, child[c]);
        if (!s->set[child[c]].expanded) extend(s, child[c], PAIRED);
    }
}

void mukca_sets_explore(mukca_sets *s, int budget, bool pairs)
{
    for (int last = -1; budget > 0 && !s->pool->failed;) { /* last: extended, and nothing since */
        const int i = next_open(s);
        if (i < 0) return;
        mukca_set *set = &s->set[i];
        if (!set->exact) {
            last = -1;
            mukca_sets_evaluate(s, i);
        } else if (!set->expanded) {
            const bool many = variants(s, set) >= VARIANTS;
            set->expanded = true;
            set->swapped = many;
            if (many) continue;
            budget--;
            extend(s, last = i, ADDED);
        } else {
            set->swapped = true;
            budget--;
            swap(s, i, i == last, pairs && i == s->best);
            last = -1;
        }
    }
}

/* Find the best set with others of its kin in place of a member and its kin: the best ones of other
 * keys, one by one, then any items. */
static void rebuild(mukca_sets *s, mukca_set set, int member)
{
    const mukca_item *all = s->question->item, *out = &all[set.item[member]];
    const mukca_scores *scores = &s->scores[0];
    for (int m = set.n - 1; m >= 0; m--)
        if (all[set.item[m]].kin == out->kin) set = reduced(&set, m);
    for (bool any = false; mukca_sets_weigh(s, &set);) {
        mukca_set next;
        for (int i = 0; i < s->question->n_items; i++)
            if (all[i].key == out->key || !(any || all[i].kin == out->kin))
                scores->value[i] = -HUGE_VAL;
        const int best = largest(scores->value, s->question->n_items);
        if (!(scores->value[best] > 0) ||
            !extended(&next, s, &set, best, scores->likeliest[best])) {
            if (any) return;
            any = true;
            continue;
        }
        const int at = find(s, &next);
        if (at < 0) return;
        mukca_sets_evaluate(s, at);
        set = s->set[at];
    }
}

void mukca_sets_rebuild(mukca_sets *s)
{
    const mukca_set set = s->set[s->best];
    for (int m = 0; m < set.n; m++)
        if (s->question->item[set.item[m]].kin) rebuild(s, set, m);
}

double mukca_sets_gain(const mukca_sets *s, const mukca_set *set, int item)
{
    return s->alone[item] - s->question->item[item].log_prior - kinship(s, set, set->n, item);
}
