/* Search among sets of causes: best first, by additions and replacements. */
#include <math.h>
#include <string.h>

#include "base/clones.h"
#include "infer/given.h"

/* Log odds behind the best set beyond which a set is not expanded (400 to 1), and behind the
 * best addition beyond which one is not kept. */
#define WINDOW 6.0

/* Log odds by which the best set must rise to be an improvement: less changes no statement. */
#define IMPROVED 1.0

enum {
    VARIANTS = 2, /* sets of the same keys that are expanded */
    ADDED = 40,   /* sets kept of each kind of expansion */
    SWAPPED = 20,
    PAIRED = 10,
    FROM = 3 /* best swaps that are extended by a second item */
};

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
        const int i = mukca_set_largest(scores->value, q->n_items);
        const double gain = scores->value[i];
        if (!isfinite(gain) || (taken && !(gain > best - WINDOW))) break;
        scores->value[i] = -HUGE_VAL;
        if (!mukca_set_extend(&next, s, set, i, scores->likeliest[i])) continue;
        best = fmax(best, gain);
        next.value = set->value + gain;
        const int at = mukca_set_find(s, &next);
        taken++;
        if (at >= 0 && n < wanted) child[n++] = at;
    }
    return n;
}

/* Set without a member. */
static mukca_set reduce(const mukca_set *set, int member)
{
    mukca_set out = *set;
    out.n--;
    memmove(out.item + member, set->item + member + 1, sizeof *out.item * (size_t)(out.n - member));
    memmove(out.size + member, set->size + member + 1, sizeof *out.size * (size_t)(out.n - member));
    out.exact = out.expanded = out.swapped = false;
    return out;
}

/* A member that is left out: k rows W of M^-1 V D G, w = M^-1 x; the log Bayes factor, and the log
 * odds, below which a replacement is of no interest. */
typedef struct {
    int k;
    const double *W;
    double w[MUKCA_MOST_TERMS], least, least_odds;
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
    const double beside = fmax(s->added[item] - h->log_prior + 5, 0),
                 job = -0.5 * s->question->dof * log1p(-fmin(common, 1) * lost / rest);
    return beside + job + 2 * sqrt(beside * job) >
           fmax(v->least, v->least_odds - h->log_prior - fmax(h->kinship, 0));
}

/* Items to be scored in addition to a set: the conditioned one, or that without a member. */
typedef struct {
    mukca_sets *sets;
    const mukca_set *set;
    const vacancy *vacancy; /* NULL: none */
    mukca_scores scores;
} scoring;

MUKCA_CLONES static void score(const scoring *job, int i, mukca_mixture_scratch *f)
{
    const mukca_sets *s = job->sets;
    const mukca_question *q = s->question;
    const mukca_item *h = &q->item[i];
    const vacancy *v = job->vacancy;
    const int terms = h->terms;
    double by_size[MUKCA_MOST_SIZES] = {0}, *G = f->A, g[MUKCA_MOST_TERMS];
    const double *given = mukca_given_of(s, i), lost = v ? mukca_set_square(v->w, v->k) : 0,
                 rest = fmin(s->integrated.posterior.quadratic + lost, q->residual);
    job->scores.value[i] = -HUGE_VAL;
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
    job->scores.value[i] =
        h->log_prior + mukca_set_kinship(s, job->set, job->set->n, i) +
        mukca_mixture_evidence(by_size, &(mukca_equations){G, g, terms, q->dof, rest}, &h->prior,
                               f);
    job->scores.likeliest[i] = (unsigned char)mukca_set_largest(by_size, h->prior.n_sizes);
}

enum { SCORED = 16 }; /* items in a block */

static void score_block(void *context, int block, int worker)
{
    const scoring *job = context;
    mukca_sets *s = job->sets;
    const int end = (block + 1) * SCORED;
    for (int i = block * SCORED; i < end && i < s->question->n_items; i++) {
        mukca_given_reduce(s, i, s->worker[worker].mixture->D);
        score(job, i, s->worker[worker].mixture);
    }
}

bool mukca_sets_weigh(mukca_sets *s, const mukca_set *set)
{
    const int n = s->question->n_items;
    if (!mukca_given_condition(s, set)) return false;
    scoring job = {s, set, NULL, s->scores[0]};
    mukca_workers_run(s->question->workers, (n + SCORED - 1) / SCORED, score_block, &job);
    memcpy(s->added, s->scores[0].value, sizeof *s->added * (size_t)n);
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
    swapping *job = context;
    mukca_sets *s = job->sets;
    const mukca_question *q = s->question;
    const mukca_item *h = &q->item[job->set->item[m]];
    const int at = s->integrated.at[m];
    double by_size[MUKCA_MOST_SIZES] = {0}, *W = s->worker[worker].row;
    mukca_mixture_scratch *f = s->worker[worker].mixture;
    vacancy v = {.W = W, .k = h->terms};
    job->member[m].possible = mukca_given_leave_out(f->D, v.w, s, m, h->terms);
    if (!job->member[m].possible) return;
    job->member[m].gain = mukca_set_score_member(by_size, s, job->set, m, f);
    memset(W, 0, sizeof *W * (size_t)(h->terms * q->stride)); /* the member's rows of V D G */
    mukca_dense_xty(W, mukca_given_inverse_of(s, m, h->terms),
                    (mukca_columns){s->integrated.B + at * q->stride, q->stride, q->stride},
                    s->integrated.posterior.n - at);
    mukca_dense_forward(W, q->stride, f->D, h->terms);
    const mukca_set less = reduce(job->set, m);
    v.least = job->pairs ? 0 : job->member[m].gain - WINDOW;
    v.least_odds = job->member[m].gain + h->log_prior - WINDOW; /* keep() meets the member, too */
    const scoring all = {s, &less, &v, s->scores[m]};
    for (int i = 0; i < q->n_items; i++) score(&all, i, f);
}

/* Drop or replace each member of a set; `weighed`: it was extended last; `pairs`: the best
 * replacements are extended, too: one item by two. */
static void swap(mukca_sets *s, int index, bool weighed, bool pairs)
{
    const mukca_set set = s->set[index];
    int child[MUKCA_SET_ITEMS * FROM], n = 0;
    swapping job = {.sets = s, .set = &set, .pairs = pairs};
    if (!set.n || !(weighed || mukca_sets_weigh(s, &set))) return;
    mukca_given_invert(s);
    mukca_workers_run(s->question->workers, set.n, swap_member, &job);
    for (int m = 0; m < set.n; m++) {
        mukca_set less = reduce(&set, m);
        if (!job.member[m].possible) continue;
        less.value = set.value - job.member[m].gain - s->question->item[set.item[m]].log_prior -
                     mukca_set_kinship(s, &less, less.n, set.item[m]);
        if (mukca_set_find(s, &less) < 0) return;
        n += keep(s, &less, &s->scores[m], SWAPPED, child + n, FROM);
    }
    for (int c = 0; c < n && pairs; c++) {
        mukca_sets_evaluate(s, child[c]);
        if (!s->set[child[c]].expanded) extend(s, child[c], PAIRED);
    }
}

void mukca_sets_explore(mukca_sets *s, int budget, bool pairs)
{
    double reached = s->set[s->best].value;
    int left = budget;
    for (int last = -1; left > 0 && !s->pool->failed;) { /* last: extended, and nothing since */
        const int i = next_open(s);
        if (s->set[s->best].value > reached + IMPROVED) {
            reached = s->set[s->best].value;
            left = budget;
        }
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
            left--;
            extend(s, last = i, ADDED);
        } else {
            set->swapped = true;
            left--;
            swap(s, i, i == last, pairs && i == s->best);
            last = -1;
        }
    }
}

double mukca_sets_gain(const mukca_sets *s, const mukca_set *set, int item)
{
    return s->added[item] - s->question->item[item].log_prior -
           mukca_set_kinship(s, set, set->n, item);
}
