/* Pooling of a fleet: the population of its coefficients; by model averaging over the sets of
 * nonzero ones (A. Raftery, D. Madigan, J. Hoeting, Bayesian model averaging for linear regression
 * models, J. Am. Stat. Assoc. 92, 1997) which of them are shared, and their sizes; arms that
 * depart, which are excluded. */
#include <math.h>
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
    REFITS = 64,      /* arms up to which one of them changes the population noticeably */
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
    if (!mukca_dense_solve(X, width, W, n)) return false;
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
        if (!mukca_dense_solve(b, 1, A, n)) return;
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
    double *P = p->scratch, *W = p->average_covariance, w[T] = {0};
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
    const double lost = p->n_arms > 1 ? (double)p->n_arms / (p->n_arms - 1) : 1; /* by the mean */
    double most = 0;
    for (int i = 0; i < p->n; i++) {
        const double usual = fmax(USUAL_SCATTER * p->trait[i].mean, USUAL_SPREAD),
                     v = pow(p->trait[i].spread, 2),
                     next = sqrt((lost * square[i] * v * v + SPREAD_ARMS * usual * usual) /
                                 (diagonal[i] + SPREAD_ARMS / v)),
                     spread = fmax(sqrt(next), LEAST_SPREAD),
                     change = fabs(spread / p->trait[i].spread - 1);
        if (change > most) most = change; /* fmax crashes gcc 12 for aarch64 */
        p->trait[i].spread = spread;
    }
    return most;
}

/* ---- which of them are not zero ---- */

/* The means as items of one column.  False: no memory. */
static bool ask_means(mukca_question *q, mukca_pool *pool, const mukca_population *p)
{
    const int n = p->n, stride = (n + 7) & ~7;
    const double quarter = log(0.25);
    mukca_item *item = MUKCA_TAKE(pool, mukca_item, n + 1);
    double *gram = MUKCA_TAKE(pool, double, n *stride + 1);
    if (pool->failed) return false;
    for (int k = 0; k < n; k++) {
        /* the sizes of mukca_sizes_spring; odds of any coefficient, then of which */
        item[k] = (mukca_item){.at = k,
                               .terms = 1,
                               .prior = {.n_sizes = 4,
                                         .size = {10e-6, 30e-6, 100e-6, 300e-6},
                                         .log_weight = {quarter, quarter, quarter, quarter},
                                         .nonnegative = true},
                               .log_prior = -log(2.0 * n),
                               .key = k};
        memcpy(gram + k * stride, p->information + k * n, sizeof *gram * (size_t)n);
    }
    *q = (mukca_question){.n_items = n,
                          .n_columns = n,
                          .stride = stride,
                          .dof = FREEDOM,
                          .residual = FREEDOM,
                          .item = item,
                          .gram = gram,
                          .g = p->vector};
    return true;
}

/* Sums over the sets of nonzero means, with their weights. */
typedef struct {
    double total, mean[T], present[T]; /* squares: in average_covariance */
} average;

/* Add a set: its coefficients are Gaussian, the others zero. */
static void add_set(average *a, mukca_population *p, const mukca_set *set, double log_weight)
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
    if (m && !mukca_dense_solve(C, m, A, m)) return;
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
static void flip_each(mukca_sets *sets, mukca_population *p)
{
    const mukca_set best = sets->set[sets->best];
    for (int k = 0; k < p->n; k++) {
        int item[T], n = 0, at = 0;
        for (int i = 0; i < p->n; i++) {
            const bool member = at < best.n && best.item[at] == i;
            at += member;
            if (member != (i == k)) item[n++] = i;
        }
        const int other = mukca_sets_insert(sets, item, NULL, n);
        const double gain = other < 0 ? 0 : sets->set[other].value - best.value;
        p->trait[k].log_bayes_factor =
            (n < best.n ? -gain : gain) - sets->question->item[k].log_prior;
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
    const bool ok = ask_means(&question, &pool, p) && mukca_sets_create(&sets, &pool, &question);
    if (ok) {
        memset(p->average_covariance, 0, sizeof p->average_covariance);
        mukca_sets_explore(&sets, BUDGET, true);
        flip_each(&sets, p);
        const double most = sets.set[sets.best].value;
        for (int i = 0; i < sets.n_sets; i++)
            add_set(&a, p, &sets.set[i], sets.set[i].value - most);
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
static bool fit_population(mukca_population *p, const mukca_fleet *f, int without, bool warm)
{
    double square[T] = {0}, diagonal[T] = {0}, *A = p->scratch, *C = p->average_covariance;
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
    memset(C, 0, sizeof p->average_covariance);
    for (int i = 0; i < p->n; i++) C[i * p->n + i] = 1;
    if (!mukca_dense_solve(C, p->n, A, p->n)) p->n = 0;
    for (int i = 0; i < p->n; i++) p->trait[i].error = sqrt(C[i * p->n + i]);
    return take_average(p);
}

/* ---- arms that depart: each compared with the posterior predictive of its sisters ---- */

/* Prior of a departure, rad/(N m): typical sizes of mukca_sizes_spring, each as probable. */
static const mukca_mixture departure_prior = {
    .n_sizes = 3,
    .size = {30e-6, 100e-6, 300e-6},
    .log_weight = {-1.0986122886681098, -1.0986122886681098, -1.0986122886681098}};

/* Comparison of an arm with its sisters. */
typedef struct {
    const mukca_population *sisters;
    double mean[T], V[T * T]; /* prior of its coefficients: mean of the sisters, covariance */
    double W[T * T], r[T];    /* its information on that mean, times residual about it */
} comparison;

/* The prior combines the uncertainty of the mean, averaged over the sets of nonzero ones, and the
 * scatter, widened for the small number of sisters (Student's t).  Of the coefficient `departing`
 * (n: none) the sisters say nothing. */
static bool compare_with_sisters(comparison *c, const mukca_fleet *f, int arm, int departing)
{
    const mukca_population *p = c->sisters;
    const int n = p->n;
    const double nu = f->n_arms, wider = nu > 2 ? nu / (nu - 2) : 3;
    double P[T * T] = {0};
    memcpy(c->mean, p->average, sizeof c->mean);
    memcpy(c->V, p->average_covariance, sizeof *c->V * (size_t)(n * n));
    for (int i = 0; i < n; i++) {
        c->V[i * n + i] += wider * p->trait[i].spread * p->trait[i].spread;
        if (i == departing) c->V[i * n + i] += MOST_MEAN * MOST_MEAN;
        P[i * n + i] = 1;
    }
    memcpy(c->W, c->V, sizeof *c->V * (size_t)(n * n));
    if (!mukca_dense_solve(P, n, c->W, n) || !arm_information(c->W, c->r, p, f, arm, P))
        return false;
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) c->r[i] -= c->W[i * n + k] * c->mean[k];
    return true;
}

static void estimate_coefficient(mukca_departure *d, const comparison *c, int k)
{
    const int n = c->sisters->n;
    const double *W = c->W, *V = c->V + k * n;
    double variance = V[k];
    d->mean = d->value = c->mean[k];
    for (int i = 0; i < n; i++) {
        d->value += V[i] * c->r[i];
        for (int j = 0; j < n; j++) variance -= V[i] * W[i * n + j] * V[j];
    }
    const double half = MUKCA_SIGMAS_95 * sqrt(fmax(variance, 0));
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
    comparison *c = MUKCA_TAKE(pool, comparison, 1);
    mukca_population *sisters = MUKCA_TAKE(pool, mukca_population, 1);
    mukca_mixture_scratch *scratch = MUKCA_TAKE(pool, mukca_mixture_scratch, 1);
    if (pool->failed) return false;
    c->sisters = sisters;
    /* Even odds that no arm of the fleet departs, whatever their number (J. Scott, J. Berger, Bayes
     * and empirical-Bayes multiplicity adjustment, Ann. Stat. 38, 2010); then any coefficient. */
    const double sound = pow(0.5, 1.0 / f->n_arms), log_prior = log((1 - sound) / (n * sound));
    for (int a = 0; a < f->n_arms; a++) {
        mukca_fleet_arm *arm = &f->arm[a];
        double odds[T + 1] = {0};
        int top = 0;
        *sisters = *all;
        arm->departure = (mukca_departure){.arm = a, .k = -1};
        arm->estimate = MUKCA_TAKE(pool, mukca_departure, n + 1);
        if (pool->failed) return false;
        if (f->n_arms < 3) continue; /* of two arms, either may depart */
        if (f->n_arms <= REFITS && !fit_population(sisters, f, a, true)) return false;
        if (!sisters->n || !compare_with_sisters(c, f, a, n)) continue;
        for (int k = 0; k < n; k++) {
            const mukca_equations one = {&c->W[k * n + k], &c->r[k], 1, FREEDOM, FREEDOM};
            odds[k] = log_prior + mukca_mixture_evidence(NULL, &one, &departure_prior, scratch);
            if (odds[k] > odds[top]) top = k;
        }
        const double total = mukca_stats_log_sum_exp(odds, n + 1); /* odds[n] = 0: none departs */
        if (exp(odds[top] - total) > 0.5 && !compare_with_sisters(c, f, a, top)) continue;
        for (int k = 0; k < n; k++) {
            arm->estimate[k] = (mukca_departure){.arm = a,
                                                 .k = k,
                                                 .effect = all->trait[k].effect,
                                                 .log_bayes_factor = odds[k] - log_prior,
                                                 .probability = exp(odds[k] - total)};
            estimate_coefficient(&arm->estimate[k], c, k);
        }
        arm->departure = arm->estimate[top];
        arm->departure.probability = 1 - exp(-total); /* of any; the top one is reported */
    }
    return true;
}

bool mukca_population_fit(mukca_fleet *f)
{
    bool ok = true, any = true;
    for (int round = 0; round < 2 && any && ok; round++) {
        ok = fit_population(&f->population, f, -1, round > 0) && find_departures(f);
        any = false; /* a broken arm has no information on its sisters: pool again without it */
        for (int a = 0; a < f->n_arms && ok && round == 0; a++)
            any |= f->arm[a].departs = f->arm[a].departure.probability >= MUKCA_DEPARTS;
    }
    return ok;
}
