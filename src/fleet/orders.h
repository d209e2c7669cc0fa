/* Orders of transmission ripple shared by a fleet. */
#ifndef MUKCA_FLEET_ORDERS_H
#define MUKCA_FLEET_ORDERS_H

#include "fleet/fleet.h"

/* order[n_joints]: the most probable order of each joint (order 0: none was scanned). */
void mukca_orders_pool(mukca_trait *order, const mukca_fleet *fleet);

#endif
