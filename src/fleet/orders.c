/* Orders of transmission ripple shared by a fleet: log Bayes factors, summed over the arms. */
#include "fleet/fleet.h"

#include <math.h>

#include "math/stats.h"

/* Share of arms that do not show the order of their gear.  The gears of a model determine its
 * orders: an individual order is a fault. */
#define FAULTY 0.1

enum { ORDERS = MUKCA_FLEET_ORDERS };

/* Log Bayes factor of an arm's own order; add to gear[] those of the arm whose gear has each order:
 * it shows that order or, rarely, its half (the other lobe of a wave generator), its double or one
 * of its own. */
static double add_arm(double *gear, const double *value)
{
    double own[ORDERS];
    for (int o = 0; o < ORDERS; o++) own[o] = value[o] + mukca_ripple_log_prior(o + 2);
    const double individual = mukca_stats_log_sum_exp(own, ORDERS), rare = log(FAULTY / 3);
    for (int o = 0; o < ORDERS; o++) {
        double shown[4] = {value[o] + log(1 - FAULTY), individual + rare};
        int n = 2;
        if (o % 2 == 0 && o >= 2) shown[n++] = value[o / 2 - 1] + rare;
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
    int best = 0;
    bool scanned = false;
    for (int a = 0; a < f->n_arms; a++) {
        if (f->arm[a].departs) continue;
        for (int o = 0; o < ORDERS; o++) {
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
    for (int o = 0; o < ORDERS; o++) {
        gear[o] += mukca_ripple_log_prior(o + 2);
        if (gear[o] > gear[best]) best = o;
    }
    const double none = pow(0.5, 1.0 / f->model.n_joints),
                 all[] = {log(2 * none / (1 - none)), each, mukca_stats_log_sum_exp(gear, ORDERS)};
    shared->effect.variant.order = best + 2;
    shared->log_bayes_factor = sum[best];
    shared->probability = exp(gear[best] - mukca_stats_log_sum_exp(all, 3));
    for (int a = 0; a < f->n_arms; a++)
        shared->arms += !f->arm[a].departs && mukca_fleet_ripple(f, a, joint, best + 2) > 0;
}

void mukca_orders_pool(mukca_trait *order, const mukca_fleet *f)
{
    for (int j = 0; j < f->model.n_joints; j++) pool_joint(&order[j], f, j);
}
