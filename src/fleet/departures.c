/* Arms that depart from their fleet: each compared with the posterior predictive of its sisters;
 * and the pooling of a fleet, from which departing arms are excluded. */
#include <math.h>
#include <string.h>

#include "fleet/fleet.h"
#include "infer/mixture.h"
#include "math/dense.h"
#include "math/stats.h"

enum {
    T = MUKCA_FLEET_TERMS,
    REFITS = 64,      /* up to this number of arms the population is fitted again without each; in
                         larger fleets one arm changes it by less than its uncertainty */
    FREEDOM = 1 << 30 /* so many degrees of freedom: the noise is known */
};

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
 * for the small number of sisters (Student's t).  `average`: averaged over the sets of nonzero
 * means, else with all coefficients present. */
static bool compare(comparison *c, const mukca_population *p, const mukca_fleet *f, int arm,
                    bool average)
{
    const int n = p->n;
    const double nu = f->n_arms, wider = nu > 2 ? nu / (nu - 2) : 3;
    c->sisters = p;
    memcpy(c->V, average ? p->average_covariance : p->covariance, sizeof *c->V * (size_t)(n * n));
    for (int i = 0; i < n; i++) {
        c->mean[i] = average ? p->average[i] : p->trait[i].mean;
        c->V[i * n + i] += wider * p->trait[i].spread * p->trait[i].spread;
    }
    memcpy(c->W, c->V, sizeof *c->V * (size_t)(n * n));
    memset(c->P, 0, sizeof c->P);
    for (int i = 0; i < n; i++) c->P[i * n + i] = 1;
    if (mukca_dense_solve(c->P, n, c->W, n)) return false;
    if (!mukca_population_arm(c->W, c->r, p, f, arm, c->P)) return false;
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

/* departure[n_arms]: the most deviant coefficient of each arm, by the posterior predictive of all
 * others; estimates[n_arms][all->n]: each arm's own coefficients with its sisters as prior.  False:
 * no memory. */
static bool find_departures(mukca_departure *departure, mukca_departure *estimates,
                            mukca_pool *pool, const mukca_population *all, const mukca_fleet *f)
{
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
        departure[a] = (mukca_departure){.arm = a, .k = -1};
        if (f->n_arms < 3) continue; /* of two arms, either may depart */
        if (f->n_arms <= REFITS && !mukca_population_fit(sisters, f, a, true)) return false;
        if (!sisters->n || !compare(c, sisters, f, a, false)) continue;
        for (int k = 0; k < n; k++) {
            odds[k] = each + mukca_mixture_evidence(by_size, &c->W[k * n + k], &c->r[k], 1, &prior,
                                                    FREEDOM, FREEDOM, scratch);
            for (int s = 0, best = 0; s < SIZES; s++)
                if (by_size[s] >= by_size[best]) best = s, size[k] = pow(prior.size[s], 2);
            if (odds[k] > odds[top]) top = k;
        }
        const double total = mukca_stats_log_sum_exp(odds, n + 1); /* odds[n] = 0: none departs */
        departure[a] = (mukca_departure){.arm = a,
                                         .effect = all->trait[top].effect,
                                         .log_bayes_factor = odds[top] - each,
                                         /* of any departure; the top one is reported */
                                         .probability = 1 - exp(-total)};
        estimate(&departure[a], c, top, size[top]);
        const bool wanted = compare(c, sisters, f, a, true);
        for (int k = 0; k < n && wanted; k++) {
            mukca_departure *e = &estimates[a * n + k];
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

mukca_status mukca_fleet_pool(mukca_fleet_result *r, mukca_fleet *f, mukca_error *error)
{
    memset(r, 0, sizeof *r);
    if (f->n_arms < 2)
        return mukca_fail(error, MUKCA_INPUT,
                          "%s: the only arm ('%s'); a fleet needs two arms or more (label the "
                          "sessions with diagnose --arm)",
                          f->session[0]->path, f->arm[0].name);
    bool ok = true, any = true;
    for (int round = 0; round < 2 && any && ok; round++) {
        ok = mukca_population_fit(&r->population, f, -1, round > 0);
        if (round == 0) {
            const size_t arms = (size_t)f->n_arms, n = (size_t)r->population.n;
            r->departure = MUKCA_TAKE(&r->pool, mukca_departure, arms);
            r->estimate = MUKCA_TAKE(&r->pool, mukca_departure, arms * (n + 1));
        }
        ok = ok && !r->pool.failed &&
             find_departures(r->departure, r->estimate, &r->pool, &r->population, f);
        any = false; /* a broken arm has no information on its sisters: pool again without it */
        for (int a = 0; a < f->n_arms && ok && round == 0; a++)
            any |= f->arm[a].departs = r->departure[a].probability >= MUKCA_DEPARTS;
    }
    if (!ok) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d arms", f->n_arms);
    mukca_orders_pool(r->order, f);
    mukca_traits *t = &r->traits;
    t->model = f->model;
    t->n_arms = f->n_arms, t->n_sessions = f->n_sessions;
    for (int a = 0; a < f->n_arms; a++) t->n_samples += f->arm[a].samples;
    t->n = r->population.n;
    memcpy(t->list, r->population.trait, (size_t)t->n * sizeof *t->list);
    for (int j = 0; j < f->model.n_joints; j++)
        if (r->order[j].probability >= MUKCA_SHARED) t->list[t->n++] = r->order[j];
    return MUKCA_OK;
}

void mukca_fleet_result_free(mukca_fleet_result *r)
{
    mukca_pool_free(&r->pool);
    memset(r, 0, sizeof *r);
}
