/* The population of a fleet's coefficients, and by model averaging over the sets of nonzero ones
 * (A. Raftery, D. Madigan, J. Hoeting, Bayesian model averaging for linear regression models, J.
 * Am. Stat. Assoc. 92, 1997) which of them are shared, and their sizes. */
#include <math.h>
#include <string.h>

#include "fleet/fleet.h"
#include "infer/sets.h"
#include "math/dense.h"
#include "math/stats.h"

enum {
    T = MUKCA_FLEET_TERMS,
    ROUNDS = 60,
    BUDGET = 40,      /* sets extended, or their members replaced */
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

bool mukca_population_arm(double *W, double *w, const mukca_population *p, const mukca_fleet *f,
                          int arm, const double *P)
{
    const int n = p->n, width = n + 1;
    double A[T * T], X[T * (T + 1)];
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++)
            X[i * width + j] = X[j * width + i] =
                f->arm[arm].information[mukca_fleet_packed(p->term[i]) + p->term[j]];
        X[i * width + n] = f->arm[arm].vector[p->term[i]];
    }
    for (int i = 0; i < n * n; i++) A[i] = P[i] + X[i / n * width + i % n];
    /* With the information L of the arm: L - L (P + L)^-1 L = P (P + L)^-1 L. */
    if (mukca_dense_solve(X, width, A, n)) return false;
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
        if (a == without || f->arm[a].departs || !mukca_population_arm(W, w, p, f, a, P)) continue;
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

bool mukca_population_fit(mukca_population *p, const mukca_fleet *f, int without, bool warm)
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

/* ---- orders of transmission ripple: log Bayes factors, summed over the arms ---- */

/* Share of arms that do not show the order of their gear.  The gears of a model determine its
 * orders: an individual order is a fault. */
#define FAULTY 0.1

enum {
    ORDERS = MUKCA_FLEET_ORDERS,
    FIRST = MUKCA_SMOOTH_ORDER - 1 /* lower ones are smooth functions, not of a gear */
};

/* Log Bayes factor of an arm's own order; add to gear[] those of the arm whose gear has each order:
 * it shows that order or, rarely, its half (the other lobe of a wave generator), its double or one
 * of its own. */
static double add_arm(double *gear, const double *value)
{
    double own[ORDERS];
    for (int o = FIRST; o < ORDERS; o++) own[o] = value[o] + mukca_ripple_log_prior(o + 2);
    const double individual = mukca_stats_log_sum_exp(own + FIRST, ORDERS - FIRST),
                 rare = log(FAULTY / 3);
    for (int o = FIRST; o < ORDERS; o++) {
        double shown[4] = {value[o] + log(1 - FAULTY), individual + rare};
        int n = 2;
        if (o % 2 == 0 && o / 2 - 1 >= FIRST) shown[n++] = value[o / 2 - 1] + rare;
        if (2 * o + 2 < ORDERS) shown[n++] = value[2 * o + 2] + rare;
        gear[o] += mukca_stats_log_sum_exp(shown, n);
    }
    return individual;
}

/* Three hypotheses of a joint: no ripple; gears of one order in all arms; an order of its own in
 * some arms.  The last keeps the fault of one arm from being attributed to the fleet.  Even odds
 * that no joint has ripple, whatever the number of joints (as in departures.c); equal odds of the
 * other two. */
static void pool_joint(mukca_trait *shared, const mukca_fleet *f, int joint)
{
    double gear[ORDERS] = {0}, sum[ORDERS] = {0}, value[ORDERS], each = 0;
    int best = FIRST;
    bool scanned = false;
    for (int a = 0; a < f->n_arms; a++) {
        for (int o = FIRST; o < ORDERS; o++) {
            value[o] = mukca_fleet_ripple(f, a, joint, o + 2);
            scanned |= value[o] != 0;
            sum[o] += value[o];
        }
        const double own[] = {log(1 - FAULTY), log(FAULTY) + add_arm(gear, value)};
        each += mukca_stats_log_sum_exp(own, 2);
    }
    *shared = (mukca_trait){
        .effect = {.kind = MUKCA_EFFECT_GEAR_HARMONIC, .joint = joint, .placement = -1, .terms = 2},
        .error = NAN,
        .spread = NAN,
        .value = NAN,
        .low = NAN,
        .high = NAN};
    if (!scanned) return;
    for (int o = FIRST; o < ORDERS; o++) {
        gear[o] += mukca_ripple_log_prior(o + 2);
        if (gear[o] > gear[best]) best = o;
    }
    const double none = pow(0.5, 1.0 / f->model.n_joints),
                 all[] = {log(2 * none / (1 - none)), each,
                          mukca_stats_log_sum_exp(gear + FIRST, ORDERS - FIRST)};
    shared->effect.variant.order = best + 2;
    shared->log_bayes_factor = sum[best];
    shared->probability = exp(gear[best] - mukca_stats_log_sum_exp(all, 3));
    for (int a = 0; a < f->n_arms; a++)
        shared->arms += mukca_fleet_ripple(f, a, joint, best + 2) > 0;
}

void mukca_orders_pool(mukca_trait *order, const mukca_fleet *f)
{
    for (int j = 0; j < f->model.n_joints; j++) pool_joint(&order[j], f, j);
}
