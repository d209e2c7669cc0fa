/* Orders of transmission ripple shared by a fleet. */
#ifndef MUKCA_FLEET_ORDERS_H
#define MUKCA_FLEET_ORDERS_H

#include "fleet/fleet.h"

typedef struct {
    int joint, order;
    double log_bayes_factor; /* sum over the arms that do not depart from the fleet */
    double probability; /* of this shared order, against other orders, individual orders and none */
    int arms;           /* number of arms whose data favour it */
} mukca_shared_order;

/* shared[n_joints]: the most probable order of each joint (order 0: none was scanned). */
void mukca_orders_pool(mukca_shared_order *shared, const mukca_fleet *fleet);

#endif
