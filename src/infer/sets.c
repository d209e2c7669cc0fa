/* Posterior probability of sets of causes. */
#include "infer/sets.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/clones.h"
#include "math/dense.h"

/* Log odds behind the best set beyond which a set is not expanded (20,000 to 1), and behind the
 * best addition beyond which one is not kept. */
#define WINDOW 10.0
#define NARROW 3.0 /* within it one item is replaced by two, too */

enum {
    TABLE = 4 * MUKCA_MOST_SETS,
    VARIANTS = 2, /* sets of the same keys that are expanded */
    ADDED = 40,   /* sets kept of each kind of expansion */
    SWAPPED = 20,
    PAIRED = 10,
    FROM = 3, /* best swaps that are extended by a second item */
    SWEEPS = 3
};

static double *gram_of(mukca_sets *s, int item)
{
    const mukca_question *q = s->question;
    const mukca_item *h = &q->item[item];
    const size_t size = (size_t)(h->terms * q->stride);
    const int rows = q->n_rows - q->n_projected;
    if (s->gram[item]) return s->gram[item];
    double *G = MUKCA_TAKE(s->pool, double, size), *P = s->with.B;
    if (!G) return NULL;
    mukca_dense_xty(G, (mukca_columns){q->E + h->at, h->terms, q->stride},
                    (mukca_columns){q->E, q->stride, q->stride}, rows);
    memset(P, 0, sizeof *P * size);
    const double *E = q->E + (size_t)rows * (size_t)q->stride;
    mukca_dense_xty(P, (mukca_columns){E + h->at, h->terms, q->stride},
                    (mukca_columns){E, q->stride, q->stride}, q->n_projected);
    for (size_t i = 0; i < size; i++) G[i] -= P[i];
    return s->gram[item] = G;
}

/* Diagonal block of an item. */
MUKCA_CLONES static void fill_block(double *G, const mukca_question *q, const mukca_item *h)
{
    const int k = h->terms;
    memset(G, 0, sizeof *G * (size_t)(k * k));
    for (int r = 0; r < q->n_rows; r++) {
        const double *e = q->E + (size_t)r * (size_t)q->stride + h->at,
                     sign = r < q->n_rows - q->n_projected ? 1 : -1;
        for (int a = 0; a < k; a++)
            for (int b = 0; b < k; b++) G[a * k + b] += sign * e[a] * e[b];
    }
}

bool mukca_sets_create(mukca_sets *s, mukca_pool *pool, const mukca_question *q)
{
    int entries = 0;
    *s = (mukca_sets){.question = q,
                      .pool = pool,
                      .gram = MUKCA_TAKE(pool, double *, q->n_items + 1),
                      .block_at = MUKCA_TAKE(pool, int, q->n_items + 1),
                      .set = MUKCA_TAKE(pool, mukca_set, MUKCA_MOST_SETS),
                      .table = MUKCA_TAKE(pool, int, TABLE),
                      .value = MUKCA_TAKE(pool, double, q->n_items + 1),
                      .order = MUKCA_TAKE(pool, int, q->n_items + 1),
                      .with = {.L = MUKCA_TAKE(pool, double, MUKCA_SET_COLUMNS *MUKCA_SET_COLUMNS),
                               .v = MUKCA_TAKE(pool, double, MUKCA_SET_COLUMNS),
                               .B = MUKCA_TAKE(pool, double, MUKCA_SET_COLUMNS *(q->stride + 1))}};
    for (int i = 0; i < q->n_items; i++) entries += q->item[i].terms * q->item[i].terms;
    s->block = MUKCA_TAKE(pool, double, entries + 1);
    if (pool->failed) return false;
    for (int i = 0, at = 0; i < q->n_items; at += q->item[i].terms * q->item[i].terms, i++)
        fill_block(s->block + (s->block_at[i] = at), q, &q->item[i]);
    memset(s->table, -1, sizeof *s->table * TABLE);
    mukca_sets_insert(s, NULL, 0);
    return true;
}

/* Integrate out a set, except its member `without` (-1: none): the residual and the factors for
 * further items. */
static bool integrate(mukca_sets *s, const mukca_set *set, int without, double *log_det)
{
    const mukca_question *q = s->question;
    int n = 0;
    *log_det = 0;
    s->with.rest = q->residual;
    for (int m = 0; m < set->n; m++) {
        const mukca_item *h = &q->item[set->item[m]];
        if (m == without) continue;
        for (int t = 0; t < h->terms; t++, n++)
            s->with.column[n] = h->at + t, s->with.size[n] = h->prior.size[set->size[m]];
    }
    s->with.n = n;
    double *L = s->with.L;
    int row = 0;
    for (int m = 0; m < set->n; m++) {
        if (m == without) continue;
        const double *G = gram_of(s, set->item[m]);
        if (!G) return false;
        for (int t = 0; t < q->item[set->item[m]].terms; t++, row++, G += q->stride) {
            const double size = s->with.size[row];
            for (int c = 0; c <= row; c++)
                L[row * n + c] = size * G[s->with.column[c]] * s->with.size[c];
            L[row * n + row] += 1;
            s->with.v[row] = size * q->g[s->with.column[row]];
        }
    }
    if (mukca_dense_cholesky(L, n)) return false;
    mukca_dense_forward(s->with.v, 1, L, n);
    double explained = 0;
    for (int i = 0; i < n; i++) {
        explained += s->with.v[i] * s->with.v[i];
        *log_det += log(L[i * n + i]);
    }
    s->with.rest = fmax(q->residual - explained, 1e-3 * q->residual);
    return true;
}

/* Columns [at, at + count) of L^-1 D G for the set integrated out, with the row stride ld. */
static void condition(mukca_sets *s, const mukca_set *set, int without, int at, int count, int ld)
{
    const mukca_question *q = s->question;
    for (int m = 0, row = 0; m < set->n; m++) {
        if (m == without) continue;
        const double *G = s->gram[set->item[m]] + at;
        for (int t = 0; t < q->item[set->item[m]].terms; t++, row++, G += q->stride)
            for (int k = 0; k < count; k++) s->with.B[row * ld + k] = s->with.size[row] * G[k];
    }
    if (count % 8)
        mukca_dense_forward(s->with.B, count, s->with.L, s->with.n);
    else
        mukca_dense_forward8(s->with.B, count, ld, s->with.L, s->with.n);
}

/* G[k][k] and g[k] of an item given the set integrated out, whose B has the item at column `at`. */
MUKCA_CLONES static void project(double *G, double *g, const mukca_sets *s, int item, int at,
                                 int ld)
{
    const mukca_item *h = &s->question->item[item];
    const int k = h->terms;
    memcpy(G, s->block + s->block_at[item], sizeof *G * (size_t)(k * k));
    memcpy(g, s->question->g + h->at, sizeof *g * (size_t)k);
    for (int i = 0; i < s->with.n; i++) {
        const double *b = s->with.B + (size_t)i * (size_t)ld + at, v = s->with.v[i];
        for (int a = 0; a < k; a++) {
            const double x = b[a];
            g[a] -= x * v;
            for (int c = 0; c < k; c++) G[a * k + c] -= x * b[c];
        }
    }
}

static double score(double *by_size, const mukca_sets *s, int item, int at, int ld)
{
    const mukca_item *h = &s->question->item[item];
    double G[MUKCA_MOST_TERMS * MUKCA_MOST_TERMS], g[MUKCA_MOST_TERMS];
    project(G, g, s, item, at, ld);
    return mukca_mixture_evidence(by_size, G, g, h->terms, &h->prior, s->with.rest,
                                  s->question->dof);
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
        memset(first, 0, sizeof *first * (size_t)s->with.n);
        first[row] = 1;
        mukca_dense_forward(first, 1, s->with.L, s->with.n);
        for (int i = row; i < s->with.n; i++) {
            mean += first[i] * s->with.v[i];
            variance += first[i] * first[i];
        }
        sum += mukca_mixture_positive(mean, variance, s->with.rest, s->question->dof);
    }
    return sum;
}

void mukca_sets_evaluate(mukca_sets *s, int index)
{
    const mukca_question *q = s->question;
    mukca_set *set = &s->set[index];
    double integral = 0, log_det;
    if (set->exact) return;
    set->exact = true;
    for (int sweep = 0, changed = 1; sweep < SWEEPS && changed; sweep++) {
        integral = 0, changed = 0;
        for (int m = 0; m < set->n; m++) {
            const mukca_item *h = &q->item[set->item[m]];
            double by_size[MUKCA_MOST_SIZES];
            if (!integrate(s, set, m, &log_det)) break;
            condition(s, set, m, h->at, h->terms, h->terms);
            const double sum = score(by_size, s, set->item[m], 0, h->terms);
            const int best = largest(by_size, h->prior.n_sizes);
            changed |= best != set->size[m];
            set->size[m] = (unsigned char)best;
            integral += sum - by_size[best] + h->prior.log_weight[best];
        }
    }
    set->value = -HUGE_VAL;
    if (integrate(s, set, -1, &log_det)) {
        set->value = integral - log_det - 0.5 * q->dof * log(s->with.rest / q->residual) +
                     weigh_signs(s, set);
        for (int m = 0; m < set->n; m++) set->value += q->item[set->item[m]].log_prior;
    }
    if (!(set->value > s->set[s->best].value) && index != s->best) return;
    for (int i = 0; i < s->n_sets; i++)
        if (s->set[i].exact && s->set[i].value > s->set[s->best].value) s->best = i;
    if (s->set[index].value >= s->set[s->best].value) s->best = index;
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
    for (; s->table[at] >= 0; at = (at + 1) % TABLE) {
        const mukca_set *other = &s->set[s->table[at]];
        if (other->n == set->n &&
            memcmp(other->item, set->item, sizeof *set->item * (size_t)set->n) == 0)
            return s->table[at];
    }
    if (s->n_sets == MUKCA_MOST_SETS) return -1;
    s->set[s->n_sets] = *set;
    return s->table[at] = s->n_sets++;
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
    out->exact = out->expanded = false;
    return columns <= MUKCA_SET_COLUMNS;
}

static mukca_set reduced(const mukca_set *set, int member)
{
    mukca_set out = *set;
    out.n--;
    memmove(out.item + member, set->item + member + 1,
            sizeof *out.item * (size_t)(out.n - member));
    memmove(out.size + member, set->size + member + 1,
            sizeof *out.size * (size_t)(out.n - member));
    out.exact = out.expanded = false;
    return out;
}

int mukca_sets_insert(mukca_sets *s, const int *item, int n)
{
    mukca_set set = {0}, next;
    for (int i = 0; i < n; i++) {
        const int middle = s->question->item[item[i]].prior.n_sizes / 2;
        if (!extended(&next, s, &set, item[i], middle)) return -1;
        set = next;
    }
    const int index = find(s, &set);
    if (index >= 0) mukca_sets_evaluate(s, index);
    return index;
}

/* Keep the best extensions of a set, at most `most`, estimated by their conditional evidence;
 * child[] receives the best `wanted`.  Returns their number. */
static int extend(mukca_sets *s, int index, int most, int *child, int wanted)
{
    const mukca_question *q = s->question;
    mukca_set set = s->set[index], next;
    double log_det, by_size[MUKCA_MOST_SIZES];
    unsigned char *size = (unsigned char *)s->order; /* scratch */
    int n = 0;
    if (!integrate(s, &set, -1, &log_det)) return 0;
    condition(s, &set, -1, 0, q->stride, q->stride);
    for (int i = 0; i < q->n_items; i++) {
        s->value[i] = score(by_size, s, i, q->item[i].at, q->stride) + q->item[i].log_prior;
        size[i] = (unsigned char)largest(by_size, q->item[i].prior.n_sizes);
    }
    double best = -HUGE_VAL;
    for (int taken = 0; taken < most;) {
        const int i = largest(s->value, q->n_items);
        const double gain = s->value[i];
        if (taken && !(gain > best - WINDOW)) break;
        if (!isfinite(gain)) break;
        s->value[i] = -HUGE_VAL;
        if (!extended(&next, s, &set, i, size[i])) continue;
        best = fmax(best, gain);
        next.value = set.value + gain;
        const int at = find(s, &next);
        taken++;
        if (at >= 0 && n < wanted) child[n++] = at;
    }
    return n;
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

/* The most probable set that is not expanded; -1: none in the window. */
static int next_open(const mukca_sets *s)
{
    int open = -1;
    for (int i = 0; i < s->n_sets; i++)
        if (!s->set[i].expanded && s->set[i].value > s->set[s->best].value - WINDOW &&
            (open < 0 || s->set[i].value > s->set[open].value))
            open = i;
    return open;
}

/* Drop or replace each member of a set. */
static void swap(mukca_sets *s, int index)
{
    const mukca_set set = s->set[index];
    for (int m = 0; m < set.n; m++) {
        const mukca_set less = reduced(&set, m);
        int child[FROM];
        const int smaller = find(s, &less);
        if (smaller < 0) continue;
        mukca_sets_evaluate(s, smaller);
        if (s->set[smaller].expanded) continue;
        const int n = extend(s, smaller, SWAPPED, child, FROM);
        for (int c = 0; c < n && set.value > s->set[s->best].value - NARROW; c++) {
            if (child[c] == index) continue;
            mukca_sets_evaluate(s, child[c]);
            if (!s->set[child[c]].expanded) extend(s, child[c], PAIRED, NULL, 0);
        }
    }
}

void mukca_sets_explore(mukca_sets *s, int budget)
{
    while (budget > 0 && !s->pool->failed) {
        const int i = next_open(s);
        if (i < 0) return;
        if (!s->set[i].exact) {
            mukca_sets_evaluate(s, i);
            continue;
        }
        const bool many = variants(s, &s->set[i]) >= VARIANTS;
        s->set[i].expanded = true;
        if (many) continue;
        budget--;
        extend(s, i, ADDED, NULL, 0);
        swap(s, i);
    }
}

double mukca_sets_gain(mukca_sets *s, const mukca_set *set, int item)
{
    const mukca_item *h = &s->question->item[item];
    double log_det;
    if (!integrate(s, set, -1, &log_det)) return -HUGE_VAL;
    condition(s, set, -1, h->at, h->terms, h->terms);
    return score(NULL, s, item, 0, h->terms);
}

void mukca_sets_gram(double *G, mukca_sets *s, const mukca_set *set, int a, int b)
{
    const mukca_item *x = &s->question->item[a], *y = &s->question->item[b];
    double log_det, left[MUKCA_SET_COLUMNS * MUKCA_MOST_TERMS];
    const double *row = gram_of(s, a);
    for (int i = 0; i < x->terms && row; i++)
        for (int k = 0; k < y->terms; k++)
            G[i * y->terms + k] = row[i * s->question->stride + y->at + k];
    if (!row || !integrate(s, set, -1, &log_det)) return;
    condition(s, set, -1, x->at, x->terms, x->terms);
    memcpy(left, s->with.B, sizeof *left * (size_t)(s->with.n * x->terms));
    condition(s, set, -1, y->at, y->terms, y->terms);
    for (int r = 0; r < s->with.n; r++)
        for (int i = 0; i < x->terms; i++)
            for (int k = 0; k < y->terms; k++)
                G[i * y->terms + k] -= left[r * x->terms + i] * s->with.B[r * y->terms + k];
}
