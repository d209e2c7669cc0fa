/* A set integrated out, and all items given it. */
#include "infer/given.h"

#include <math.h>
#include <string.h>

enum { STRIPE = 64 }; /* columns of all items at a time */

/* Columns of a stripe. */
static int width_of(const mukca_question *q, int stripe)
{
    const int left = q->stride - stripe * STRIPE;
    return left < STRIPE ? left : STRIPE;
}

static int stripes(const mukca_question *q)
{
    return (q->stride + STRIPE - 1) / STRIPE;
}

void mukca_question_copy(double *out, int ld, const mukca_question *q, mukca_span columns,
                         mukca_span rows)
{
    for (int k = 0, count; k < columns.n; k += count) {
        const int at = columns.from + k, from = at % MUKCA_PANEL, left = MUKCA_PANEL - from;
        const double *e = q->E + (size_t)(at - from) * (size_t)q->n_rows + rows.from * MUKCA_PANEL;
        count = left < columns.n - k ? left : columns.n - k;
        for (int r = 0; r < rows.n; r++)
            memcpy(out + (size_t)r * (size_t)ld + k, e + r * MUKCA_PANEL + from,
                   sizeof *out * (size_t)count);
    }
}

typedef struct {
    const mukca_sets *sets;
    int width; /* columns of the items, in sets->left */
    double *G; /* [width][stride] */
} gram_rows;

static void fill_rows(void *context, int stripe, int worker)
{
    const gram_rows *f = context;
    const mukca_question *q = f->sets->question;
    const int rows = q->n_rows - q->n_projected, from = stripe * STRIPE, n = width_of(q, stripe);
    const mukca_columns left = {f->sets->left, f->width, f->width},
                        T = {left.x + (size_t)rows * (size_t)f->width, f->width, f->width};
    double *G = f->G + from, *less = f->sets->worker[worker].row;
    memset(less, 0, sizeof *less * (size_t)(f->width * n));
    for (int k = 0; k < n; k += MUKCA_PANEL) {
        const double *E = q->E + (size_t)(from + k) * (size_t)q->n_rows;
        mukca_dense_xty_part(G + k, q->stride, left, (mukca_columns){E, MUKCA_PANEL, MUKCA_PANEL},
                             rows);
        mukca_dense_xty_part(less + k, n, T,
                             (mukca_columns){E + rows * MUKCA_PANEL, MUKCA_PANEL, MUKCA_PANEL},
                             q->n_projected);
    }
    for (int i = 0; i < f->width; i++)
        for (int k = 0; k < n; k++) G[(size_t)i * (size_t)q->stride + (size_t)k] -= less[i * n + k];
}

bool mukca_given_rows(mukca_sets *s, const unsigned short *item, int n)
{
    const mukca_question *q = s->question;
    const size_t stride = (size_t)q->stride;
    for (int i = 0; i < n && q->gram; i++)
        s->gram[item[i]] = q->gram + (size_t)q->item[item[i]].at * stride;
    for (int i = 0; i < n && !q->gram;) {
        const int first = i;
        int width = 0;
        for (; i < n && width + q->item[item[i]].terms <= MUKCA_GIVEN_TOGETHER; i++)
            width += s->gram[item[i]] ? 0 : q->item[item[i]].terms;
        if (!width) continue;
        double *G = MUKCA_TAKE(s->pool, double, (size_t)width *stride);
        if (!G) return false;
        for (int k = first, to = 0; k < i; k++) {
            const mukca_item *h = &q->item[item[k]];
            if (s->gram[item[k]]) continue;
            mukca_question_copy(s->left + to, width, q, (mukca_span){h->at, h->terms},
                                (mukca_span){0, q->n_rows});
            s->gram[item[k]] = G + (size_t)to * stride;
            to += h->terms;
        }
        mukca_workers_run(q->workers, stripes(q), fill_rows, &(gram_rows){s, width, G});
    }
    return true;
}

/* Subtract X'X from G[X.n][X.n]; explained[X.n][X.n]: scratch. */
static void subtract_products(double *G, double *explained, mukca_columns X, int rows)
{
    memset(explained, 0, sizeof *G * (size_t)(X.n * X.n));
    mukca_dense_symmetric(explained, X, X, rows);
    for (int i = 0; i < X.n * X.n; i++) G[i] -= explained[i];
}

void mukca_given_blocks(const mukca_sets *s, int item, int end, int worker)
{
    const mukca_question *q = s->question;
    const int rows = q->n_rows - q->n_projected;
    mukca_mixture_scratch *f = s->worker[worker].mixture;
    double *x = s->worker[worker].row;
    while (item < end) {
        const int first = item, at = q->item[first].at;
        int n = 0;
        do n += q->item[item++].terms;
        while (item < end && n + q->item[item].terms <= MUKCA_NEIGHBOURS);
        const mukca_columns E = {x, n, n}, T = {x + (size_t)rows * (size_t)n, n, n};
        if (!q->gram) {
            mukca_question_copy(x, n, q, (mukca_span){at, n}, (mukca_span){0, q->n_rows});
            mukca_dense_symmetric(memset(f->C, 0, sizeof *f->C * (size_t)(n * n)), E, E, rows);
            subtract_products(f->C, f->D, T, q->n_projected);
        }
        for (int i = first; i < item; i++) {
            const mukca_item *h = &q->item[i];
            const double *from =
                q->gram ? q->gram + (long)h->at * q->stride + h->at : f->C + (h->at - at) * (n + 1);
            for (int t = 0; t < h->terms; t++, from += q->gram ? q->stride : n)
                memcpy(s->block[i] + t * h->terms, from, sizeof *from * (size_t)h->terms);
        }
    }
}

void mukca_sets_products_of(double *G, mukca_sets *s, int a, int b)
{
    const mukca_question *q = s->question;
    const mukca_item *x = &q->item[a], *y = &q->item[b];
    const size_t size = sizeof *G * (size_t)(x->terms * y->terms);
    memset(G, 0, size);
    if (a == b) memcpy(G, s->block[a], size);
    if (a == b || (!s->gram[a] && !s->gram[b] &&
                   !mukca_given_rows(s, &(unsigned short){(unsigned short)a}, 1)))
        return;
    for (int i = 0; i < x->terms; i++)
        for (int k = 0; k < y->terms; k++)
            G[i * y->terms + k] = s->gram[a] ? s->gram[a][i * q->stride + y->at + k]
                                             : s->gram[b][k * q->stride + x->at + i];
}

bool mukca_given_integrate(mukca_sets *s, const mukca_set *set)
{
    const mukca_question *q = s->question;
    mukca_posterior *posterior = &s->integrated.posterior;
    double *P = posterior->factor, *G = s->scratch->A;
    int n = 0;
    for (int m = 0; m < set->n; m++) {
        const mukca_item *h = &q->item[set->item[m]];
        s->integrated.at[m] = n;
        for (int t = 0; t < h->terms; t++, n++) {
            posterior->prior[n] = h->prior.size[set->size[m]];
            posterior->work[n] = q->g[h->at + t];
        }
    }
    posterior->n = n;
    posterior->quadratic = q->residual;
    for (int m = 0; m < set->n; m++)
        for (int o = 0; o <= m; o++) {
            const mukca_item *h = &q->item[set->item[m]];
            const int terms = q->item[set->item[o]].terms, row = s->integrated.at[m],
                      column = s->integrated.at[o];
            mukca_sets_products_of(G, s, set->item[m], set->item[o]);
            for (int t = 0; t < h->terms; t++)
                for (int c = 0; c < terms; c++) P[(row + t) * n + column + c] = G[t * terms + c];
        }
    if (!mukca_posterior_solve(posterior, NULL)) return false;
    posterior->quadratic = fmax(posterior->quadratic, 1e-3 * q->residual);
    return true;
}

/* Row stride of the inverse factor. */
static int padded(const mukca_sets *s)
{
    return (s->integrated.posterior.n + 7) & ~7;
}

void mukca_given_invert(mukca_sets *s)
{
    const mukca_posterior *p = &s->integrated.posterior;
    const int n = p->n, ld = padded(s);
    double *T = s->integrated.inverse;
    memset(T, 0, sizeof *T * (size_t)(n * ld));
    for (int i = 0; i < n; i++) T[i * ld + i] = 1;
    for (int k = 0; k < n; k += 8) /* above their own rows the columns are 0 */
        mukca_dense_forward_part(T + k * ld + k, ld, p->factor + k * n + k, n, n - k);
    memcpy(s->integrated.x, p->work, sizeof *T * (size_t)n);
    mukca_dense_backward(s->integrated.x, 1, p->factor, n);
}

mukca_columns mukca_given_inverse_of(const mukca_sets *s, int member, int terms)
{
    const int ld = padded(s), at = s->integrated.at[member];
    return (mukca_columns){s->integrated.inverse + at * ld + at, terms, ld};
}

bool mukca_given_leave_out(double *M, double *w, const mukca_sets *s, int member, int terms)
{
    const mukca_columns T = mukca_given_inverse_of(s, member, terms);
    const int at = s->integrated.at[member];
    memset(M, 0, sizeof *M * (size_t)(terms * terms));
    mukca_dense_symmetric(M, T, T, s->integrated.posterior.n - at);
    if (!mukca_dense_cholesky(M, terms)) return false;
    memcpy(w, s->integrated.x + at, sizeof *w * (size_t)terms);
    mukca_dense_forward(w, 1, M, terms);
    return true;
}

typedef struct {
    mukca_sets *sets;
    const mukca_set *set;
} conditioning;

/* B := L^-1 D G for the set integrated out, and g given it, in a stripe of the columns. */
static void condition_stripe(void *context, int stripe, int worker)
{
    const conditioning *c = context;
    mukca_sets *s = c->sets;
    const mukca_question *q = s->question;
    const mukca_posterior *p = &s->integrated.posterior;
    const int from = stripe * STRIPE, n = width_of(q, stripe);
    double *B = s->integrated.B + from, *g = s->g + from;
    (void)worker;
    for (int m = 0, row = 0; m < c->set->n; m++) {
        const double *G = s->gram[c->set->item[m]] + from;
        for (int t = 0; t < q->item[c->set->item[m]].terms; t++, row++, G += q->stride)
            for (int k = 0; k < n; k++) B[row * q->stride + k] = p->prior[row] * G[k];
    }
    mukca_dense_forward8(B, n, q->stride, p->factor, p->n);
    memset(g, 0, sizeof *g * (size_t)n);
    mukca_dense_xty(g, (mukca_columns){p->work, 1, 1}, (mukca_columns){B, n, q->stride}, p->n);
    for (int k = 0; k < n && from + k < q->n_columns; k++) g[k] = q->g[from + k] - g[k];
}

double *mukca_given_of(const mukca_sets *s, int item)
{
    return s->given + (s->block[item] - s->block[0]);
}

void mukca_given_reduce(const mukca_sets *s, int item, double *scratch)
{
    const mukca_item *h = &s->question->item[item];
    double *G = mukca_given_of(s, item);
    memcpy(G, s->block[item], sizeof *G * (size_t)(h->terms * h->terms));
    subtract_products(G, scratch,
                      (mukca_columns){s->integrated.B + h->at, h->terms, s->question->stride},
                      s->integrated.posterior.n);
}

bool mukca_given_condition(mukca_sets *s, const mukca_set *set)
{
    if (!mukca_given_integrate(s, set) || !mukca_given_rows(s, set->item, set->n)) return false;
    mukca_workers_run(s->question->workers, stripes(s->question), condition_stripe,
                      &(conditioning){s, set});
    return true;
}

void mukca_sets_mean(double *mean, mukca_sets *s, const mukca_set *set)
{
    const mukca_posterior *p = &s->integrated.posterior;
    memset(mean, 0, sizeof *mean * (size_t)s->question->stride);
    if (!mukca_given_integrate(s, set)) return;
    mukca_dense_backward(p->work, 1, p->factor, p->n);
    for (int m = 0, row = 0; m < set->n; m++) {
        const mukca_item *h = &s->question->item[set->item[m]];
        for (int t = 0; t < h->terms; t++, row++) mean[h->at + t] = p->prior[row] * p->work[row];
    }
}

void mukca_sets_products(double *product, double *mean, mukca_sets *s, const mukca_set *set)
{
    const mukca_item *item = s->question->item;
    double *G = s->scratch->A;
    mukca_sets_mean(mean, s, set);
    for (int a = 0; a < set->n; a++)
        for (int b = 0; b <= a; b++) {
            const mukca_item *x = &item[set->item[a]], *y = &item[set->item[b]];
            double sum = 0;
            mukca_sets_products_of(G, s, set->item[a], set->item[b]);
            for (int i = 0; i < x->terms; i++)
                for (int k = 0; k < y->terms; k++)
                    sum += mean[x->at + i] * G[i * y->terms + k] * mean[y->at + k];
            product[a * set->n + b] = product[b * set->n + a] = sum;
        }
}

int mukca_sets_covariance(double *V, mukca_sets *s)
{
    const int n = s->integrated.posterior.n, ld = padded(s);
    const double *T = s->integrated.inverse, *D = s->integrated.posterior.prior;
    mukca_given_invert(s);
    memset(V, 0, sizeof *V * (size_t)(n * n));
    mukca_dense_symmetric(V, (mukca_columns){T, n, ld}, (mukca_columns){T, n, ld}, n);
    for (int i = 0; i < n * n; i++) V[i] *= D[i / n] * D[i % n];
    return n;
}
