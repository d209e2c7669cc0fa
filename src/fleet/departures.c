/* Arms that depart from their fleet: each compared with the posterior predictive of its sisters. */
#include "fleet/departures.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "math/stats.h"

enum {
    T = MUKCA_FLEET_TERMS,
    REFITS = 64 /* up to this number of arms the spread is fitted again without each; in larger
                   fleets one arm changes it by less than its uncertainty */
};

/* Prior sigmas of a departure, rad/(N m): typical sizes of mukca_sizes_spring. */
static const double sizes[] = {30e-6, 100e-6, 300e-6};
enum { SIZES = sizeof sizes / sizeof *sizes };

/* Comparison of an arm with its sisters. */
typedef struct {
    const mukca_population *sisters;
    const double *mean;   /* of the sisters */
    double V[T * T];      /* prior covariance of its coefficients */
    mukca_arm_evidence w; /* its evidence on the mean; e: the residual about the sisters' mean */
} comparison;

/* The prior of the arm's coefficients combines the uncertainty of the mean and the scatter, widened
 * for the small number of sisters (Student's t).  `average`: averaged over the sets of nonzero
 * means, else with all coefficients present. */
static bool compare(comparison *c, const mukca_population *p, const mukca_fleet *f, int arm,
                    bool average)
{
    const int n = p->n;
    const double nu = f->n_arms, wider = nu > 2 ? nu / (nu - 2) : 3;
    mukca_arm_evidence own = {0};
    *c = (comparison){.sisters = p, .mean = average ? p->average : p->mean};
    memcpy(c->V, average ? p->average_covariance : p->covariance, sizeof *c->V * (size_t)(n * n));
    for (int i = 0; i < n; i++) c->V[i * n + i] += wider * p->spread[i] * p->spread[i];
    mukca_population_arm(&own, p, f, arm);
    if (!mukca_population_scatter(&c->w, &own, c->V, n)) return false;
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) c->w.e[i] -= c->w.L[i * n + k] * c->mean[k];
    return true;
}

/* Estimate coefficient k of the arm, with its prior variance increased by s2. */
static void estimate(mukca_departure *d, const comparison *c, int k, double s2)
{
    const int n = c->sisters->n;
    const double *W = c->w.L, *V = c->V;
    const double shrink = s2 / (1 + s2 * W[k * n + k]);
    double own = 0, variance = V[k * n + k] + s2, row[T] = {0};
    for (int i = 0; i < n; i++) {
        row[i] = V[k * n + i] + (i == k ? s2 : 0);
        own += row[i] * (c->w.e[i] - shrink * W[i * n + k] * c->w.e[k]);
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            variance -= row[i] * row[j] * (W[i * n + j] - shrink * W[i * n + k] * W[k * n + j]);
    const double half = MUKCA_FLEET_INTERVAL * sqrt(fmax(variance, 0));
    d->mean = c->mean[k];
    d->value = d->mean + own;
    d->low = fmax(d->value - half, 0), d->high = d->value + half;
    d->ratio = d->mean > 0 ? d->value / d->mean : (double)INFINITY;
}

/* Log Bayes factor of a departure in coefficient k; *best: the most probable prior variance. */
static double departs(const comparison *c, int k, double *best)
{
    const double W = c->w.L[k * c->sisters->n + k], r = c->w.e[k];
    double value[SIZES], most = -HUGE_VAL;
    for (int s = 0; s < SIZES; s++) {
        const double s2 = sizes[s] * sizes[s], d = 1 + s2 * W;
        value[s] = -0.5 * log(d) + 0.5 * s2 * r * r / d - log(SIZES);
        if (value[s] > most) most = value[s], *best = s2;
    }
    return mukca_stats_log_sum_exp(value, SIZES);
}

/* Remove one arm from the population, with unchanged spread. */
static void downdate(mukca_population *p, const mukca_fleet *f, int arm)
{
    const int n = p->n;
    double V[T * T] = {0}, A[T * T], b[T];
    mukca_arm_evidence own = {0}, w = {0};
    for (int i = 0; i < n; i++) V[i * n + i] = p->spread[i] * p->spread[i];
    mukca_population_arm(&own, p, f, arm);
    if (!mukca_population_scatter(&w, &own, V, n)) return;
    for (int i = 0; i < n * n; i++) A[i] = p->information[i] - w.L[i];
    for (int i = 0; i < n; i++) b[i] = p->vector[i] - w.e[i];
    if (mukca_dense_cholesky(A, n)) return;
    mukca_dense_forward(b, 1, A, n);
    mukca_dense_backward(b, 1, A, n);
    for (int i = 0; i < n; i++) p->mean[i] = fmax(b[i], 0);
}

bool mukca_departures_find(mukca_departure *departure, mukca_departure *estimates,
                           const mukca_population *all, const mukca_fleet *f)
{
    const int n = all->n;
    /* Even odds that no arm of the fleet departs, whatever their number (J. Scott, J. Berger, Bayes
     * and empirical-Bayes multiplicity adjustment, Ann. Stat. 38, 2010); then any coefficient. */
    const double alone = pow(0.5, 1.0 / f->n_arms), each = log((1 - alone) / (n * alone));
    for (int a = 0; a < f->n_arms; a++) {
        mukca_population sisters = *all;
        comparison c, own;
        double odds[T + 1] = {0}, size[T] = {0};
        int top = 0;
        departure[a] = (mukca_departure){.arm = a, .k = -1};
        if (f->n_arms < 3) continue; /* of two arms, either may depart */
        if (f->n_arms <= REFITS && !mukca_population_fit(&sisters, f, a, true)) return false;
        if (f->n_arms > REFITS && !f->arm[a].departs) downdate(&sisters, f, a);
        if (!sisters.n || !compare(&c, &sisters, f, a, false)) continue;
        for (int k = 0; k < n; k++) {
            odds[k] = departs(&c, k, &size[k]) + each;
            if (odds[k] > odds[top]) top = k;
        }
        odds[n] = 0;
        const double total = mukca_stats_log_sum_exp(odds, n + 1);
        departure[a].k = top;
        departure[a].effect = mukca_fleet_term(all->term[top], f->model.n_joints);
        departure[a].log_bayes_factor = odds[top] - each;
        departure[a].probability = 1 - exp(-total); /* of any departure; the top one is reported */
        estimate(&departure[a], &c, top, size[top]);
        const bool wanted = estimates && compare(&own, &sisters, f, a, true);
        for (int k = 0; k < n && wanted; k++) {
            mukca_departure *e = &estimates[a * n + k];
            *e = (mukca_departure){.arm = a,
                                   .k = k,
                                   .effect = mukca_fleet_term(all->term[k], f->model.n_joints),
                                   .log_bayes_factor = odds[k] - each,
                                   .probability = exp(odds[k] - total)};
            estimate(e, &own, k, exp(odds[k] - total) > 0.5 ? size[k] : 0);
        }
    }
    return true;
}
