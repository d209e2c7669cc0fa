/* Pooling of a fleet: the population of its coefficients; by model averaging over the sets of
 * nonzero ones (A. Raftery, D. Madigan, J. Hoeting, Bayesian model averaging for linear regression
 * models, J. Am. Stat. Assoc. 92, 1997) which of them are shared, and their sizes; arms that
 * depart, which are excluded. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fleet/fleet.h"
#include "infer/mixture.h"
#include "infer/sets.h"
#include "math/dense.h"
#include "math/stats.h"

enum {
    T = MUKCA_FLEET_TERMS,
    ROUNDS = 60,
    BUDGET = 40,      /* sets extended, or their members replaced */
    REFITS = 64,      /* up to this number of arms the population is fitted again without each; in
                         larger fleets one arm changes it by less than its uncertainty */
    FREEDOM = 1 << 30 /* so many degrees of freedom: the noise is known */
};

/* Initial spread and its lower bound, rad/(N m): springs of 10 urad/(N m) that differ by a
 * tenth. */
#define FIRST_SPREAD 20e-6
#define LEAST_SPREAD 1e-6
/* Prior of the spread, with the weight of so many arms: gears of one type scatter by a fifth (data
 * sheets of strain wave gears state a minimum stiffness of 80 % of the mean), and two arms cannot
 * determine it. */
#define SPREAD_ARMS 2.0
#define USUAL_SCATTER 0.2
#define USUAL_SPREAD 4e-6 /* rad/(N m): a fifth of 20 urad/(N m), a typical spring */
/* Relative change at which the fit stops: far below the uncertainty with a thousand arms. */
#define SETTLED 1e-3
/* Prior sigma of a mean, rad/(N m): the largest size of mukca_sizes_spring. */
#define MOST_MEAN 300e-6
/* Of a set: negligible in a sum, and far from underflow. */
#define LEAST_LOG_WEIGHT (-200.0)

/* Information W[n][n] of an arm on the population's mean, and information times estimate, if the
 * prior precision of its coefficients about the mean is P[n][n].  False: not positive definite. */
static bool arm_information(double *W, double *w, const mukca_population *p, const mukca_fleet *f,
                            int arm, const double *P)
{
    const int n = p->n, width = n + 1;
    double X[T * (T + 1)];
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++)
            X[i * width + j] = X[j * width + i] =
                f->arm[arm].information[mukca_fleet_packed(p->term[i]) + p->term[j]];
        X[i * width + n] = f->arm[arm].vector[p->term[i]];
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) W[i * n + j] = P[i * n + j] + X[i * width + j];
    /* With the information L of the arm: L - L (P + L)^-1 L = P (P + L)^-1 L. */
    if (mukca_dense_solve(X, width, W, n)) return false;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < width; j++) {
            double sum = 0;
            for (int k = 0; k < n; k++) sum += P[i * n + k] * X[k * width + j];
            *(j < n ? &W[i * n + j] : &w[i]) = sum;
        }
    return true;
}

/* Select the coefficients on which at least one arm has information. */
static void choose_terms(mukca_population *p, const mukca_fleet *f)
{
    p->n = 0;
    for (int t = 0; t < f->n_terms; t++) {
        int arms = 0;
        for (int a = 0; a < f->n_arms; a++)
            arms += f->arm[a].information[mukca_fleet_packed(t) + t] > 0;
        if (!arms) continue;
        p->trait[p->n] = (mukca_trait){
            .effect = mukca_fleet_term(t, f->model.n_joints), .spread = FIRST_SPREAD, .arms = arms};
        p->term[p->n++] = t;
    }
}

/* Best non-negative mean: repeatedly fix the most negative coefficient at zero. */
static void solve_mean(mukca_population *p)
{
    const int n = p->n;
    bool held[T] = {false};
    double A[T * T], b[T];
    for (int round = 0; round <= n; round++) {
        int worst = -1;
        for (int i = 0; i < n; i++) {
            b[i] = held[i] ? 0 : p->vector[i];
            for (int j = 0; j <= i; j++)
                A[i * n + j] = held[i] || held[j] ? i == j : p->information[i * n + j];
        }
        if (mukca_dense_solve(b, 1, A, n)) return;
        for (int i = 0; i < n; i++)
            if (b[i] < 0 && (worst < 0 || b[i] < b[worst])) worst = i;
        if (worst < 0) break;
        held[worst] = true;
    }
    for (int i = 0; i < n; i++) p->trait[i].mean = fmax(b[i], 0);
}

/* Information on the mean; scatter of the arms about it: residual^2, and information on the
 * diagonal. */
static void sum_arms(mukca_population *p, double *square, double *diagonal, const mukca_fleet *f,
                     int without)
{
    const int n = p->n;
    double *P = p->scratch, *W = p->covariance, w[T] = {0};
    memset(P, 0, sizeof p->scratch);
    memset(p->information, 0, sizeof p->information);
    memset(p->vector, 0, sizeof p->vector);
    p->n_arms = 0;
    for (int i = 0; i < n; i++) {
        P[i * n + i] = 1 / (p->trait[i].spread * p->trait[i].spread);
        square[i] = diagonal[i] = 0;
        /* coefficients identifiable only in combination are bounded by the size of springs */
        p->information[i * n + i] = 1 / (MOST_MEAN * MOST_MEAN);
    }
    for (int a = 0; a < f->n_arms; a++) {
        if (a == without || f->arm[a].departs || !arm_information(W, w, p, f, a, P)) continue;
        p->n_arms++;
        for (int i = 0; i < n; i++) {
            double r = w[i];
            for (int k = 0; k < n; k++) r -= W[i * n + k] * p->trait[k].mean;
            square[i] += r * r;
            diagonal[i] += W[i * n + i];
            p->vector[i] += w[i];
        }
        for (int i = 0; i < n * n; i++) p->information[i] += W[i];
    }
}

/* Multiplicative steps for the spread (H. Zhou et al., MM algorithms for variance components
 * models, J. Comput. Graph. Stat. 28, 2019); each raises the restricted likelihood times the
 * prior. */
static double step_spread(mukca_population *p, const double *square, const double *diagonal)
{
    double most = 0;
    for (int i = 0; i < p->n; i++) {
        const double usual = fmax(USUAL_SCATTER * p->trait[i].mean, USUAL_SPREAD),
                     v = pow(p->trait[i].spread, 2);
        /* correction for the fitted mean of n arms */
        const double lost = p->n_arms > 1 ? (double)p->n_arms / (p->n_arms - 1) : 1;
        const double next = sqrt((lost * square[i] * v * v + SPREAD_ARMS * usual * usual) /
                                 (diagonal[i] + SPREAD_ARMS / v));
        const double spread = fmax(sqrt(next), LEAST_SPREAD);
        const double change = fabs(spread / p->trait[i].spread - 1);
        if (change > most) most = change; /* fmax crashes gcc 12 for aarch64 */
        p->trait[i].spread = spread;
    }
    return most;
}

/* ---- which of them are not zero ---- */

/* The means as items of one column, with information E'E.  False: no memory, or E does not exist.
 */
static bool ask(mukca_question *q, mukca_pool *pool, const mukca_population *p)
{
    const int n = p->n, stride = (n + 7) & ~7;
    const double each = log(0.25);
    mukca_item *item = MUKCA_TAKE(pool, mukca_item, n + 1);
    double *E = MUKCA_TAKE(pool, double, n *stride + 1), L[T * T];
    memcpy(L, p->information, sizeof *L * (size_t)(n * n));
    if (pool->failed || mukca_dense_cholesky(L, n)) return false;
    for (int k = 0; k < n; k++) {
        /* the sizes of mukca_sizes_spring; odds of any coefficient, then of which */
        item[k] = (mukca_item){.at = k,
                               .terms = 1,
                               .prior = {.n_sizes = 4,
                                         .size = {10e-6, 30e-6, 100e-6, 300e-6},
                                         .log_weight = {each, each, each, each},
                                         .nonnegative = true},
                               .log_prior = -log(2.0 * n),
                               .key = k};
        for (int r = 0; r <= k; r++) E[r * stride + k] = L[k * n + r];
    }
    *q = (mukca_question){.n_items = n,
                          .n_columns = n,
                          .stride = stride,
                          .n_rows = n,
                          .dof = FREEDOM,
                          .residual = FREEDOM,
                          .item = item,
                          .E = E,
                          .g = p->vector};
    return true;
}

/* Sums over the sets of nonzero means, with their weights. */
typedef struct {
    double total, mean[T], present[T]; /* squares: in average_covariance */
} average;

/* Add a set: its coefficients are Gaussian, the others zero. */
static void take(average *a, mukca_population *p, const mukca_set *set, double log_weight)
{
    const int n = p->n, m = set->n;
    const unsigned short *index = set->item;
    double *A = p->scratch, *sum = p->average_covariance, C[T * T] = {0}, mean[T] = {0};
    /* the lower bound preserves the value of a coefficient that is almost certainly 0 */
    const double weight = exp(fmax(log_weight, LEAST_LOG_WEIGHT));
    for (int i = 0; i < m; i++) {
        C[i * m + i] = 1;
        for (int j = 0; j <= i; j++) A[i * m + j] = p->information[index[i] * n + index[j]];
    }
    if (m && mukca_dense_solve(C, m, A, m)) return;
    a->total += weight;
    for (int i = 0; i < m; i++)
        for (int j = 0; j < m; j++) mean[i] += C[i * m + j] * p->vector[index[j]];
    for (int i = 0; i < m; i++) {
        a->mean[index[i]] += weight * mean[i];
        a->present[index[i]] += weight;
        for (int j = 0; j < m; j++)
            sum[index[i] * n + index[j]] += weight * (C[i * m + j] + mean[i] * mean[j]);
    }
}

/* Evaluate the most probable set with each coefficient added or dropped. */
static void flip(mukca_sets *sets, mukca_population *p)
{
    const mukca_set best = sets->set[sets->best];
    for (int k = 0; k < p->n; k++) {
        int item[T], n = 0, at = 0;
        bool present = false;
        for (int i = 0; i < p->n; i++) {
            const bool member = at < best.n && best.item[at] == i;
            at += member;
            if (i == k) present = member;
            if (member != (i == k)) item[n++] = i;
        }
        const int other = mukca_sets_insert(sets, item, NULL, n);
        const double gain = other < 0 ? 0 : sets->set[other].value - best.value;
        p->trait[k].log_bayes_factor = (present ? -gain : gain) - sets->question->item[k].log_prior;
    }
}

/* Averages, values and probabilities from information and vector.  False: no memory. */
static bool take_average(mukca_population *p)
{
    const int n = p->n;
    if (n == 0) return true;
    mukca_pool pool = {0};
    mukca_question question;
    mukca_sets sets;
    average a = {.total = 0};
    const bool ok = ask(&question, &pool, p) && mukca_sets_create(&sets, &pool, &question);
    if (ok) {
        memset(p->average_covariance, 0, sizeof p->average_covariance);
        mukca_sets_explore(&sets, BUDGET, true);
        flip(&sets, p);
        const double most = sets.set[sets.best].value;
        for (int i = 0; i < sets.n_sets; i++) take(&a, p, &sets.set[i], sets.set[i].value - most);
    }
    for (int i = 0; i < n && ok; i++) {
        const double present = a.present[i], value = a.mean[i] / present;
        double *row = &p->average_covariance[i * n];
        const double half = MUKCA_SIGMAS_95 * sqrt(fmax(row[i] / present - value * value, 0));
        p->trait[i].probability = present / a.total;
        p->trait[i].value = fmax(value, 0);
        p->trait[i].low = fmax(value - half, 0), p->trait[i].high = fmax(value + half, 0);
        p->average[i] = fmax(a.mean[i] / a.total, 0);
        for (int j = 0; j < n; j++) row[j] = (row[j] - a.mean[i] * a.mean[j] / a.total) / a.total;
    }
    const bool failed = pool.failed;
    mukca_pool_free(&pool);
    return !failed;
}

/* Fit the population to all arms but those that depart and `without` (-1: none), starting from the
 * present mean and spread if `warm`.  False: no memory. */
static bool fit(mukca_population *p, const mukca_fleet *f, int without, bool warm)
{
    double square[T] = {0}, diagonal[T] = {0}, *A = p->scratch;
    if (!warm) choose_terms(p, f);
    for (int round = 0; round < ROUNDS; round++) {
        sum_arms(p, square, diagonal, f, without);
        solve_mean(p);
        if (round == 0) sum_arms(p, square, diagonal, f, without); /* residuals about that mean */
        if (step_spread(p, square, diagonal) < SETTLED) break;
    }
    sum_arms(p, square, diagonal, f, without);
    solve_mean(p);
    memcpy(A, p->information, sizeof *A * (size_t)(p->n * p->n));
    memset(p->covariance, 0, sizeof p->covariance);
    for (int i = 0; i < p->n; i++) p->covariance[i * p->n + i] = 1;
    if (mukca_dense_solve(p->covariance, p->n, A, p->n)) p->n = 0;
    for (int i = 0; i < p->n; i++) p->trait[i].error = sqrt(p->covariance[i * p->n + i]);
    return take_average(p);
}

/* ---- arms that depart: each compared with the posterior predictive of its sisters ---- */

/* Prior of a departure, rad/(N m): typical sizes of mukca_sizes_spring, each as probable. */
#define SIZES 3
static const mukca_mixture prior = {
    .n_sizes = SIZES,
    .size = {30e-6, 100e-6, 300e-6},
    .log_weight = {-1.0986122886681098, -1.0986122886681098, -1.0986122886681098}};

/* Comparison of an arm with its sisters. */
typedef struct {
    const mukca_population *sisters;
    double mean[T];            /* of the sisters */
    double V[T * T], P[T * T]; /* prior covariance of its coefficients, and its inverse */
    double W[T * T], r[T]; /* its information on the mean, times residual about the sisters' mean */
} comparison;

/* The prior of the arm's coefficients combines the uncertainty of the mean and the scatter, widened
 * for the small number of sisters (Student's t).  `averaged`: over the sets of nonzero
 * means, else with all coefficients present. */
static bool compare(comparison *c, const mukca_population *p, const mukca_fleet *f, int arm,
                    bool averaged)
{
    const int n = p->n;
    const double nu = f->n_arms, wider = nu > 2 ? nu / (nu - 2) : 3;
    c->sisters = p;
    memcpy(c->V, averaged ? p->average_covariance : p->covariance, sizeof *c->V * (size_t)(n * n));
    for (int i = 0; i < n; i++) {
        c->mean[i] = averaged ? p->average[i] : p->trait[i].mean;
        c->V[i * n + i] += wider * p->trait[i].spread * p->trait[i].spread;
    }
    memcpy(c->W, c->V, sizeof *c->V * (size_t)(n * n));
    memset(c->P, 0, sizeof c->P);
    for (int i = 0; i < n; i++) c->P[i * n + i] = 1;
    if (mukca_dense_solve(c->P, n, c->W, n)) return false;
    if (!arm_information(c->W, c->r, p, f, arm, c->P)) return false;
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) c->r[i] -= c->W[i * n + k] * c->mean[k];
    return true;
}

/* Estimate coefficient k of the arm, with its prior variance increased by s2. */
static void estimate(mukca_departure *d, const comparison *c, int k, double s2)
{
    const int n = c->sisters->n;
    const double *W = c->W, *V = c->V;
    const double shrink = s2 / (1 + s2 * W[k * n + k]);
    double own = 0, variance = V[k * n + k] + s2, row[T] = {0};
    for (int i = 0; i < n; i++) {
        row[i] = V[k * n + i] + (i == k ? s2 : 0);
        own += row[i] * (c->r[i] - shrink * W[i * n + k] * c->r[k]);
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            variance -= row[i] * row[j] * (W[i * n + j] - shrink * W[i * n + k] * W[k * n + j]);
    const double half = MUKCA_SIGMAS_95 * sqrt(fmax(variance, 0));
    d->k = k;
    d->mean = c->mean[k];
    d->value = d->mean + own;
    d->low = fmax(d->value - half, 0), d->high = d->value + half;
    d->ratio = d->mean > 0 ? d->value / d->mean : (double)INFINITY;
}

/* The most deviant coefficient of each arm, by the posterior predictive of all others; its own
 * coefficients with its sisters as prior.  False: no memory. */
static bool find_departures(mukca_fleet *f)
{
    const mukca_population *all = &f->population;
    mukca_pool *pool = &f->pool;
    const int n = all->n;
    mukca_population *sisters = MUKCA_TAKE(pool, mukca_population, 1);
    comparison *c = MUKCA_TAKE(pool, comparison, 1);
    mukca_mixture_scratch *scratch = MUKCA_TAKE(pool, mukca_mixture_scratch, 1);
    if (pool->failed) return false;
    /* Even odds that no arm of the fleet departs, whatever their number (J. Scott, J. Berger, Bayes
     * and empirical-Bayes multiplicity adjustment, Ann. Stat. 38, 2010); then any coefficient. */
    const double alone = pow(0.5, 1.0 / f->n_arms), each = log((1 - alone) / (n * alone));
    for (int a = 0; a < f->n_arms; a++) {
        double odds[T + 1] = {0}, size[T] = {0}, by_size[MUKCA_MOST_SIZES] = {0};
        int top = 0;
        *sisters = *all;
        f->arm[a].departure = (mukca_departure){.arm = a, .k = -1};
        f->arm[a].estimate = MUKCA_TAKE(pool, mukca_departure, n + 1);
        if (pool->failed) return false;
        if (f->n_arms < 3) continue; /* of two arms, either may depart */
        if (f->n_arms <= REFITS && !fit(sisters, f, a, true)) return false;
        if (!sisters->n || !compare(c, sisters, f, a, false)) continue;
        for (int k = 0; k < n; k++) {
            const mukca_equations one = {&c->W[k * n + k], &c->r[k], 1, FREEDOM, FREEDOM};
            odds[k] = each + mukca_mixture_evidence(by_size, &one, &prior, scratch);
            for (int s = 0, best = 0; s < SIZES; s++)
                if (by_size[s] >= by_size[best]) best = s, size[k] = pow(prior.size[s], 2);
            if (odds[k] > odds[top]) top = k;
        }
        const double total = mukca_stats_log_sum_exp(odds, n + 1); /* odds[n] = 0: none departs */
        f->arm[a].departure = (mukca_departure){.arm = a,
                                                .effect = all->trait[top].effect,
                                                .log_bayes_factor = odds[top] - each,
                                                /* of any departure; the top one is reported */
                                                .probability = 1 - exp(-total)};
        estimate(&f->arm[a].departure, c, top, size[top]);
        const bool wanted = compare(c, sisters, f, a, true);
        for (int k = 0; k < n && wanted; k++) {
            mukca_departure *e = &f->arm[a].estimate[k];
            const double share = exp(odds[k] - total);
            *e = (mukca_departure){.arm = a,
                                   .effect = all->trait[k].effect,
                                   .log_bayes_factor = odds[k] - each,
                                   .probability = share};
            estimate(e, c, k, share > 0.5 ? size[k] : 0);
        }
    }
    return true;
}

static int by_probability(const void *a, const void *b)
{
    const mukca_departure *x = a, *y = b;
    if (x->probability != y->probability) return x->probability < y->probability ? 1 : -1;
    if (x->log_bayes_factor != y->log_bayes_factor)
        return x->log_bayes_factor < y->log_bayes_factor ? 1 : -1;
    return x->arm - y->arm;
}

mukca_status mukca_fleet_pool(mukca_fleet *f, mukca_error *error)
{
    mukca_traits *t = &f->traits;
    if (f->n_arms < 2)
        return mukca_fail(error, MUKCA_INPUT,
                          "%s: the only arm ('%s'); a fleet needs two arms or more (label the "
                          "sessions with diagnose --arm)",
                          f->session[0]->path, f->arm[0].name);
    bool ok = true, any = true;
    f->ranked = MUKCA_TAKE(&f->pool, mukca_departure, f->n_arms);
    for (int round = 0; round < 2 && any && ok; round++) {
        ok = fit(&f->population, f, -1, round > 0) && find_departures(f);
        any = false; /* a broken arm has no information on its sisters: pool again without it */
        for (int a = 0; a < f->n_arms && ok && round == 0; a++)
            any |= f->arm[a].departs = f->arm[a].departure.probability >= MUKCA_DEPARTS;
    }
    if (!ok) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d arms", f->n_arms);
    mukca_orders_pool(f);
    *t = (mukca_traits){
        .model = f->model, .n = f->population.n, .n_arms = f->n_arms, .n_sessions = f->n_sessions};
    for (int a = 0; a < f->n_arms; a++) {
        t->n_samples += f->arm[a].samples;
        f->ranked[a] = f->arm[a].departure;
    }
    qsort(f->ranked, (size_t)f->n_arms, sizeof *f->ranked, by_probability);
    memcpy(t->list, f->population.trait, (size_t)t->n * sizeof *t->list);
    for (int j = 0; j < f->model.n_joints; j++)
        if (f->order[j].probability >= MUKCA_SHARED) t->list[t->n++] = f->order[j];
    return MUKCA_OK;
}
