/* Pooling of a gathered fleet: orders of ripple that its arms share, and its traits. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "effect/catalogue.h"
#include "fleet/fleet.h"
#include "math/stats.h"

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
static double add_arm(double *gear, const double *value, const double *prior)
{
    double separate[ORDERS];
    for (int o = FIRST; o < ORDERS; o++) separate[o] = value[o] + prior[o];
    const double individual = mukca_stats_log_sum_exp(separate + FIRST, ORDERS - FIRST),
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

/* Log Bayes factor of an order of ripple, over all sessions of an arm. */
static double ripple_of(const mukca_fleet *f, int arm, int joint, int order)
{
    int quanta = 0;
    for (int s = f->arm[arm].first; s < f->arm[arm].end; s++)
        quanta += f->session[s]->ripple[joint][order - 2];
    return quanta * MUKCA_FLEET_QUANTUM;
}

/* Three hypotheses of a joint: no ripple; gears of one order in all arms; an order of its own in
 * some arms.  The last keeps the fault of one arm from being attributed to the fleet.  Even odds
 * that no joint has ripple, whatever the number of joints (as in population.c); equal odds of the
 * other two. */
static void pool_joint(mukca_trait *shared, const mukca_fleet *f, int joint)
{
    const mukca_effect wave = mukca_fleet_wave(joint);
    double gear[ORDERS] = {0}, sum[ORDERS] = {0}, value[ORDERS], prior[ORDERS], each = 0;
    int best = FIRST;
    bool scanned = false;
    for (int o = FIRST; o < ORDERS; o++)
        prior[o] = log(mukca_effect_catalogue[wave.kind]->order_prior(o + 2));
    for (int a = 0; a < f->n_arms; a++) {
        for (int o = FIRST; o < ORDERS; o++) {
            value[o] = ripple_of(f, a, joint, o + 2);
            scanned |= value[o] != 0;
            sum[o] += value[o];
        }
        const double separate[] = {log(1 - FAULTY), log(FAULTY) + add_arm(gear, value, prior)};
        each += mukca_stats_log_sum_exp(separate, 2);
    }
    *shared = (mukca_trait){
        .effect = wave, .error = NAN, .spread = NAN, .value = NAN, .low = NAN, .high = NAN};
    if (!scanned) return;
    for (int o = FIRST; o < ORDERS; o++) {
        gear[o] += prior[o];
        if (gear[o] > gear[best]) best = o;
    }
    const double none = pow(0.5, 1.0 / f->model.n_joints),
                 all[] = {log(2 * none / (1 - none)), each,
                          mukca_stats_log_sum_exp(gear + FIRST, ORDERS - FIRST)};
    shared->effect.variant.order = best + 2;
    shared->log_bayes_factor = sum[best];
    shared->probability = exp(gear[best] - mukca_stats_log_sum_exp(all, 3));
    for (int a = 0; a < f->n_arms; a++) shared->arms += ripple_of(f, a, joint, best + 2) > 0;
}

void mukca_orders_pool(mukca_fleet *f)
{
    for (int j = 0; j < f->model.n_joints; j++) pool_joint(&f->order[j], f, j);
}

/* ---- the whole fleet ---- */

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
    f->ranked = MUKCA_TAKE(&f->pool, mukca_departure, f->n_arms);
    if (!f->ranked || !mukca_population_fit(f))
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d arms", f->n_arms);
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
