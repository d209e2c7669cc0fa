/* Products of the columns of the regression, noise of each joint, questions. */
#include "motion/torques.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"

/* Largest correlation of successive rows: a random walk is a drift, not noise. */
#define MOST_CORRELATION 0.98
/* Least noise, relative to the range: no drive measures its torque to better than 1 in 1000. */
#define LEAST_NOISE 1e-3
const mukca_part_weights mukca_torques_whole = {{[MUKCA_PART_NEW] = 1, [MUKCA_PART_REFERENCE] = 1}};

mukca_torque_columns mukca_torque_columns_take(mukca_pool *pool, int n)
{
    return (mukca_torque_columns){.column = MUKCA_TAKE(pool, int, n + 1),
                                  .factor = MUKCA_TAKE(pool, double, n + 1)};
}

static void append(mukca_torque_columns *c, int first, int n, double factor)
{
    for (int i = 0; i < n; i++, c->n++) c->column[c->n] = first + i, c->factor[c->n] = factor;
}

void mukca_torque_columns_parameters(mukca_torque_columns *c, const mukca_torques *t)
{
    append(c, 0, t->items.n_parameters, 1);
}

void mukca_torque_columns_value(mukca_torque_columns *c, const mukca_torques *t)
{
    append(c, t->items.n_parameters, 1, 1);
}

void mukca_torque_columns_item(mukca_torque_columns *c, const mukca_torques *t, int item,
                               double size)
{
    const mukca_item *h = &t->items.item[item];
    append(c, t->items.n_parameters + 1 + h->at, h->terms, size);
}

double mukca_torques_rows(const mukca_torques *t, const mukca_part_weights *parts, int joint)
{
    double rows = 1e-6;
    for (int g = 0; g < MUKCA_PARTS; g++) rows += parts->of[g] * t->part[g].rows[joint];
    return rows;
}

/* The terms of some columns at one joint. */
typedef struct {
    int *first; /* [n + 1] */
    mukca_raw_term *term;
    int *active, n_active; /* columns with terms */
    double *H, *raw;       /* [n_active][width], [width][width] */
} mapping;

static bool take_mapping(mapping *m, mukca_pool *pool, const mukca_torques *t,
                         const mukca_torque_columns *c)
{
    const int width = mukca_raw_width(t->n, 0);
    int terms = 0;
    for (int k = 0; k < c->n; k++)
        terms += t->items.first[c->column[k] + 1] - t->items.first[c->column[k]];
    m->first = MUKCA_TAKE(pool, int, c->n + 1);
    m->term = MUKCA_TAKE(pool, mukca_raw_term, terms + 1);
    m->active = MUKCA_TAKE(pool, int, c->n + 1);
    m->H = MUKCA_TAKE(pool, double, c->n *width + 1);
    m->raw = MUKCA_TAKE(pool, double, width *width);
    return !pool->failed;
}

/* Gather the terms at a joint; `items`: of effects, too. */
static void map(mapping *m, const mukca_torques *t, const mukca_torque_columns *c, int joint,
                bool items)
{
    int n = 0;
    m->n_active = 0;
    for (int k = 0; k < c->n; k++) {
        m->first[k] = n;
        if (c->column[k] > t->items.n_parameters && !items) continue;
        for (int i = t->items.first[c->column[k]]; i < t->items.first[c->column[k] + 1]; i++) {
            if (t->items.term[i].joint != joint) continue;
            m->term[n] = t->items.term[i];
            m->term[n++].weight *= c->factor[k];
        }
        if (n > m->first[k]) m->active[m->n_active++] = k;
    }
    m->first[c->n] = n;
}

static void add_mapped(double *G, int n, mapping *m, int width, double factor)
{
    for (int a = 0; a < m->n_active; a++) {
        double *h = m->H + a * width;
        memset(h, 0, sizeof *h * (size_t)width);
        for (int i = m->first[m->active[a]]; i < m->first[m->active[a] + 1]; i++) {
            const double *row = m->raw + m->term[i].raw * width, w = factor * m->term[i].weight;
            for (int r = 0; r < width; r++) h[r] += w * row[r];
        }
    }
    for (int a = 0; a < m->n_active; a++)
        for (int b = a; b < m->n_active; b++) {
            const int x = m->active[a], y = m->active[b];
            double sum = 0;
            for (int i = m->first[y]; i < m->first[y + 1]; i++)
                sum += m->term[i].weight * m->H[a * width + m->term[i].raw];
            G[x * n + y] += sum;
            if (x != y) G[y * n + x] += sum;
        }
}

bool mukca_torques_multiply(double *G, const mukca_torques *t, const mukca_torque_columns *c,
                            const mukca_part_weights *parts, int joint, bool whitened)
{
    mukca_pool pool = {0};
    mapping m = {0};
    const bool ok = take_mapping(&m, &pool, t, c);
    for (int j = 0; j < t->n && ok; j++) {
        const int width = mukca_raw_width(t->n, j);
        if (joint >= 0 && j != joint) continue;
        for (int items = 0; items < 2; items++) { /* effects are absent from the reference */
            double sum = 0;
            memset(m.raw, 0, sizeof *m.raw * (size_t)(width * width));
            for (int g = 0; g < MUKCA_PARTS; g++) {
                if ((g != MUKCA_PART_REFERENCE) != items || parts->of[g] == 0) continue;
                mukca_raw_products_add(m.raw, &t->part[g], j, width, whitened ? t->rho[j] : 0,
                                       parts->of[g]);
                sum += parts->of[g] * t->part[g].rows[j];
            }
            if (!(sum > 0)) continue;
            map(&m, t, c, j, items);
            add_mapped(G, c->n, &m, width, joint >= 0 ? 1 : 1 / (t->sigma[j] * t->sigma[j]));
        }
    }
    mukca_pool_free(&pool);
    return ok;
}

/* L := factor of 1 + G without the last column, which is the value; x := mean, -1 for the value. */
static bool solve(double *x, double *L, const double *G, int width)
{
    const int n = width - 1;
    for (int i = 0; i < n; i++) {
        memcpy(L + i * n, G + i * width, sizeof *L * (size_t)n);
        L[i * n + i] += 1;
        x[i] = G[i * width + n];
    }
    if (!mukca_dense_cholesky(L, n)) return false;
    mukca_dense_forward(x, 1, L, n);
    mukca_dense_backward(x, 1, L, n);
    x[n] = -1;
    return true;
}

/* A fit of all joints, and what one of them contributes; [width][width]. */
typedef struct {
    int width;
    double *G, *L, *x; /* products; factor, and mean */
    double *S, *D;     /* products of a joint's rows, and of their differences */
    double *scratch;
} noise_fit;

/* Noise of a joint about the mean of the fit. */
static void update_noise(mukca_torques *t, int j, const noise_fit *f)
{
    const int width = f->width, n = width - 1;
    double *scratch = f->scratch;
    const double rho = t->rho[j], a = (1 - rho) * (1 - rho),
                 rows = mukca_torques_rows(t, &mukca_torques_whole, j);
    const double squares = mukca_dense_quadratic(f->x, f->S, width, width),
                 steps = mukca_dense_quadratic(f->x, f->D, width, width);
    double used = 0; /* trace of (1 + G)^-1 G, the joint's part */
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++)
            scratch[i * n + k] = a * f->S[i * width + k] + rho * f->D[i * width + k];
    mukca_dense_forward(scratch, n, f->L, n);
    mukca_dense_backward(scratch, n, f->L, n);
    for (int i = 0; i < n; i++) used += scratch[i * n + i] / (t->sigma[j] * t->sigma[j]);
    t->sigma[j] = sqrt(fmax(a * squares + rho * steps, 0) / fmax(rows - used, 0.2 * rows));
    t->sigma[j] = fmax(t->sigma[j], LEAST_NOISE * t->model.signals->range[j]);
    t->rho[j] = fmin(fmax(1 - 0.5 * steps / fmax(squares, 1e-300), 0), MOST_CORRELATION);
}

mukca_torque_columns mukca_torque_columns_of(mukca_pool *pool, const mukca_torques *t,
                                             const mukca_torque_set *set, int room)
{
    const mukca_items *all = &t->items;
    int n = all->n_parameters + 1 + (room < 0 ? all->n_items + 2 * t->n : room);
    for (int i = 0; set && i < set->n; i++) n += all->item[set->item[i]].terms;
    mukca_torque_columns c = mukca_torque_columns_take(pool, n);
    if (pool->failed) return c;
    mukca_torque_columns_parameters(&c, t);
    for (int i = 0; set && i < set->n; i++)
        mukca_torque_columns_item(&c, t, set->item[i], set->size[i]);
    for (int i = 0; room < 0 && i < all->n_items; i++) {
        const mukca_torque_effect *row = &mukca_torque_table[all->row[i]];
        const mukca_mixture *prior = &all->item[i].prior;
        if (row->name && row->n == 1)
            mukca_torque_columns_item(&c, t, i, prior->size[prior->n_sizes - 1]);
    }
    if (room < 0) append(&c, all->drift, 2 * t->n, 1);
    mukca_torque_columns_value(&c, t);
    return c;
}

bool mukca_torques_measure_noise(mukca_torques *t, const mukca_torque_set *set)
{
    mukca_pool pool = {0};
    const mukca_torque_columns c = mukca_torque_columns_of(&pool, t, set, -1);
    const int w = c.n;
    const size_t square = (size_t)w * (size_t)w;
    const noise_fit f = {.width = w,
                         .G = MUKCA_TAKE(&pool, double, w *w),
                         .L = MUKCA_TAKE(&pool, double, w *w),
                         .x = MUKCA_TAKE(&pool, double, w),
                         .S = MUKCA_TAKE(&pool, double, w *w),
                         .D = MUKCA_TAKE(&pool, double, w *w),
                         .scratch = MUKCA_TAKE(&pool, double, w *w)};
    bool ok = !pool.failed;
    for (int j = 0; j < t->n; j++) /* at first */
        if (!(t->sigma[j] > 0)) t->sigma[j] = 0.1 * t->model.signals->range[j];
    for (int iteration = 0; iteration < 4 && ok; iteration++) {
        memset(f.G, 0, sizeof *f.G * square);
        ok = mukca_torques_multiply(f.G, t, &c, &mukca_torques_whole, -1, true) &&
             solve(f.x, f.L, f.G, w);
        for (int j = 0; j < t->n && ok; j++) {
            const double rho = t->rho[j];
            memset(f.S, 0, sizeof *f.S * square);
            memset(f.D, 0, sizeof *f.D * square);
            t->rho[j] = 1; /* products of the differences */
            ok = mukca_torques_multiply(f.S, t, &c, &mukca_torques_whole, j, false) &&
                 mukca_torques_multiply(f.D, t, &c, &mukca_torques_whole, j, true);
            t->rho[j] = rho;
            update_noise(t, j, &f);
        }
    }
    mukca_pool_free(&pool);
    return ok;
}

bool mukca_torques_fit(double *mean, const mukca_torques *t, const mukca_torque_columns *c,
                       const mukca_part_weights *parts)
{
    mukca_pool pool = {0};
    double *G = MUKCA_TAKE(&pool, double, c->n * c->n), *L = MUKCA_TAKE(&pool, double, c->n * c->n);
    const bool ok =
        !pool.failed && mukca_torques_multiply(G, t, c, parts, -1, true) && solve(mean, L, G, c->n);
    mukca_pool_free(&pool);
    return ok;
}

bool mukca_torques_ask(mukca_question *question, mukca_pool *pool, const mukca_torques *t,
                       const mukca_torque_choice *choice, const mukca_part_weights *parts)
{
    mukca_pool scratch = {0};
    mukca_item *item = MUKCA_TAKE(pool, mukca_item, choice->n + 1);
    mukca_part_layout layout = {.n_items = choice->n, .item = item};
    for (int i = 0; item && i < choice->n; i++) {
        item[i] = t->items.item[choice->item[i]];
        item[i].at = layout.n_columns;
        layout.n_columns += item[i].terms;
    }
    mukca_torque_columns c = mukca_torque_columns_of(&scratch, t, choice->held, layout.n_columns);
    layout.n = c.n - 1;
    const int width = c.n + layout.n_columns;
    double *G = MUKCA_TAKE(&scratch, double, width *width);
    double rows = 0;
    for (int j = 0; j < t->n; j++) rows += mukca_torques_rows(t, parts, j);
    bool ok = item && !scratch.failed;
    if (ok) {
        for (int i = 0; i < choice->n; i++) mukca_torque_columns_item(&c, t, choice->item[i], 1);
        ok = mukca_torques_multiply(G, t, &c, parts, -1, true) &&
             mukca_part_question(question, pool, G, (int)rows, &layout);
    }
    mukca_pool_free(&scratch);
    return ok;
}
