/* Posterior probability of sets of causes. */
#include "infer/given.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { TABLE = 4 * MUKCA_MOST_SETS, SWEEPS = 3, TOGETHER = 16 /* items in a block */ };

/* Memory to integrate out a set. */
static void take_integral(mukca_sets *s, mukca_pool *pool)
{
    mukca_posterior_take(&s->integrated.posterior, pool, MUKCA_SET_COLUMNS);
    s->integrated.inverse = MUKCA_TAKE(pool, double, MUKCA_SET_COLUMNS *MUKCA_SET_COLUMNS);
    s->integrated.x = MUKCA_TAKE(pool, double, MUKCA_SET_COLUMNS);
}

static void fill_blocks(void *context, int block, int worker)
{
    mukca_sets *s = context;
    const int n = s->question->n_items, end = (block + 1) * TOGETHER;
    mukca_given_blocks(s, block * TOGETHER, end < n ? end : n, worker);
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
        .added = MUKCA_TAKE(pool, double, q->n_items + 1),
        .g = MUKCA_TAKE(pool, double, q->stride + 1),
        .given = MUKCA_TAKE(pool, double, squares + 1),
        .left = MUKCA_TAKE(pool, double, MUKCA_GIVEN_TOGETHER *(q->n_rows + MUKCA_SET_COLUMNS)),
        .integrated.B = MUKCA_TAKE(pool, double, MUKCA_SET_COLUMNS *(q->stride + 1))};
    take_integral(s, pool);
    for (int m = 0; m < MUKCA_SET_ITEMS; m++)
        s->scores[m] = (mukca_scores){MUKCA_TAKE(pool, double, q->n_items + 1),
                                      MUKCA_TAKE(pool, unsigned char, q->n_items + 1)};
    for (int k = 0; k < mukca_workers_count(q->workers); k++) {
        s->worker[k].row =
            MUKCA_TAKE(pool, double, MUKCA_GIVEN_TOGETHER *(q->stride + q->n_rows + 1));
        s->worker[k].mixture = MUKCA_TAKE(pool, mukca_mixture_scratch, 1);
    }
    s->scratch = s->worker[0].mixture;
    double *block = MUKCA_TAKE(pool, double, squares + 1);
    if (pool->failed) return false;
    for (int i = 0; i < q->n_items; block += q->item[i].terms * q->item[i].terms, i++)
        s->block[i] = block;
    mukca_workers_run(q->workers, (q->n_items + TOGETHER - 1) / TOGETHER, fill_blocks, s);
    mukca_sets_insert(s, NULL, NULL, 0);
    return true;
}

double mukca_set_square(const double *x, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += x[i] * x[i];
    return sum;
}

double mukca_set_score_member(double *by_size, const mukca_sets *s, const mukca_set *set,
                              int member, mukca_mixture_scratch *f)
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
    const double rest =
        fmin(s->integrated.posterior.quadratic + mukca_set_square(w, k), s->question->residual);
    return mukca_mixture_evidence(by_size, &(mukca_equations){G, g, k, s->question->dof, rest},
                                  &h->prior, f);
}

int mukca_set_largest(const double *x, int n)
{
    int best = 0;
    for (int i = 1; i < n; i++)
        if (x[i] > x[best]) best = i;
    return best;
}

/* Log probability of the signs of all nonnegative items of the set integrated out. */
static double weigh_signs(mukca_sets *s, const mukca_set *set)
{
    const mukca_posterior *p = &s->integrated.posterior;
    double sum = 0, first[MUKCA_SET_COLUMNS];
    for (int m = 0, row = 0; m < set->n; row += s->question->item[set->item[m++]].terms) {
        double mean = 0, variance = 0;
        if (!s->question->item[set->item[m]].prior.nonnegative) continue;
        memset(first, 0, sizeof *first * (size_t)p->n);
        first[row] = 1;
        mukca_dense_forward(first, 1, p->factor, p->n);
        for (int i = row; i < p->n; i++) {
            mean += first[i] * p->work[i];
            variance += first[i] * first[i];
        }
        sum += mukca_mixture_positive(mean, variance, p->quadratic, s->question->dof);
    }
    return sum;
}

double mukca_set_kinship(const mukca_sets *s, const mukca_set *set, int n, int item)
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
            const double sum = mukca_set_score_member(by_size, s, set, m, s->scratch);
            const int best =
                sum > -HUGE_VAL ? mukca_set_largest(by_size, h->prior.n_sizes) : set->size[m];
            integral += sum - by_size[best] + h->prior.log_weight[best];
            if (best == set->size[m]) continue;
            changed = true;
            set->size[m] = (unsigned char)best;
            ok = mukca_given_integrate(s, set);
            mukca_given_invert(s);
        }
    }
    set->value = integral - s->integrated.posterior.log_det -
                 0.5 * q->dof * log(s->integrated.posterior.quadratic / q->residual) +
                 weigh_signs(s, set);
    for (int m = 0; m < set->n; m++)
        set->value += q->item[set->item[m]].log_prior + mukca_set_kinship(s, set, m, set->item[m]);
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

int mukca_set_find(mukca_sets *s, const mukca_set *set)
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

bool mukca_set_extend(mukca_set *out, const mukca_sets *s, const mukca_set *set, int item, int size)
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

int mukca_sets_insert(mukca_sets *s, const int *item, const double *size, int n)
{
    mukca_set set = {0}, next;
    for (int i = 0; i < n; i++) {
        const mukca_mixture *prior = &s->question->item[item[i]].prior;
        int nearest = size ? 0 : prior->n_sizes / 2;
        for (int k = 1; k < prior->n_sizes && size; k++)
            if (fabs(prior->size[k] - size[i]) < fabs(prior->size[nearest] - size[i])) nearest = k;
        if (!mukca_set_extend(&next, s, &set, item[i], nearest)) return -1;
        set = next;
    }
    if (!mukca_given_rows(s, set.item, set.n)) return -1;
    const int index = mukca_set_find(s, &set);
    if (index >= 0) mukca_sets_evaluate(s, index);
    return index;
}

int mukca_by_odds(const void *a, const void *b)
{
    const mukca_ranked *x = a, *y = b;
    return x->odds != y->odds ? (x->odds < y->odds) - (x->odds > y->odds) : x->index - y->index;
}
