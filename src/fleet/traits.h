/* The traits of a robot model: results of its fleet, as prior for one more arm. */
#ifndef MUKCA_FLEET_TRAITS_H
#define MUKCA_FLEET_TRAITS_H

#include "fleet/departures.h"
#include "fleet/orders.h"

enum { MUKCA_MAX_TRAITS = MUKCA_FLEET_TERMS + MUKCA_MAX_JOINTS };

typedef struct {
    mukca_fleet_model model;
    int n, n_arms, n_sessions, n_samples;
    mukca_trait list[MUKCA_MAX_TRAITS];
} mukca_traits;

/* Results of a fleet. */
typedef struct {
    mukca_population population;
    mukca_trait order[MUKCA_MAX_JOINTS];   /* [n_joints]: the most probable; 0: none was scanned */
    mukca_departure *departure, *estimate; /* [n_arms], [n_arms][population.n] */
    mukca_traits traits;                   /* [population.n] coefficients, then the shared orders */
    mukca_pool pool;
} mukca_fleet_result;

/* Pool a gathered fleet.  Arms that depart are marked and excluded from its population.  Errors:
 * MUKCA_INPUT (fewer than two arms), MUKCA_MEMORY. */
mukca_status mukca_fleet_pool(mukca_fleet_result *result, mukca_fleet *fleet, mukca_error *error);
void mukca_fleet_result_free(mukca_fleet_result *result);

#endif
