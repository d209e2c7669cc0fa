/* Orders of transmission ripple shared by a fleet: log Bayes factors, summed over the arms. */
#include "fleet/orders.h"

#include <math.h>

#include "math/stats.h"

/* Share of arms with an individual order.  The gears of a model determine its orders: an individual
 * order is a fault. */
#define FAULTY 0.1

/* Three hypotheses of a joint: no ripple; all arms have ripple of one order; some arms have an
 * individual order.  The last keeps the fault of one arm from being attributed to the fleet.  Even
 * odds that no joint has ripple, whatever the number of joints (as in departures.c); equal odds of
 * the other two. */
static void pool_joint(mukca_shared_order *shared, const mukca_fleet *f, int joint)
{
    double pooled[MUKCA_FLEET_ORDERS] = {0}, own[MUKCA_FLEET_ORDERS + 1], all[3];
    double each = 0;
    bool scanned = false;
    for (int a = 0; a < f->n_arms; a++) {
        if (f->arm[a].departs) continue;
        for (int o = 0; o < MUKCA_FLEET_ORDERS; o++) {
            const double value = mukca_fleet_ripple(f, a, joint, o + 2);
            scanned |= value != 0;
            pooled[o] += value;
            own[o] = value + mukca_ripple_log_prior(o + 2) + log(FAULTY);
        }
        own[MUKCA_FLEET_ORDERS] = log(1 - FAULTY);
        each += mukca_stats_log_sum_exp(own, MUKCA_FLEET_ORDERS + 1);
    }
    *shared = (mukca_shared_order){.joint = joint};
    if (!scanned) return;
    int best = 0;
    for (int o = 0; o < MUKCA_FLEET_ORDERS; o++) {
        own[o] = pooled[o] + mukca_ripple_log_prior(o + 2);
        if (own[o] > own[best]) best = o;
    }
    const double none = pow(0.5, 1.0 / f->model.n_joints);
    all[0] = log(2 * none / (1 - none)), all[1] = each,
    all[2] = mukca_stats_log_sum_exp(own, MUKCA_FLEET_ORDERS);
    shared->order = best + 2;
    shared->log_bayes_factor = pooled[best];
    shared->probability = exp(own[best] - mukca_stats_log_sum_exp(all, 3));
    for (int a = 0; a < f->n_arms; a++)
        shared->arms += !f->arm[a].departs && mukca_fleet_ripple(f, a, joint, best + 2) > 0;
}

void mukca_orders_pool(mukca_shared_order *shared, const mukca_fleet *f)
{
    for (int j = 0; j < f->model.n_joints; j++) pool_joint(&shared[j], f, j);
}
