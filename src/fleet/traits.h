/* The traits of a robot model: results of its fleet, as prior for one more arm. */
#ifndef MUKCA_FLEET_TRAITS_H
#define MUKCA_FLEET_TRAITS_H

#include "fleet/departures.h"
#include "fleet/orders.h"

enum { MUKCA_MAX_TRAITS = MUKCA_FLEET_TERMS + MUKCA_MAX_JOINTS };

/* A coefficient or (gear_harmonic) an order of ripple, with mean 0 because the phase differs
 * between arms. */
typedef struct {
    mukca_effect effect;
    /* rad/(N m): mean of the arms and its standard error with all coefficients present, the prior
     * of one more arm; value and 95 % interval as in mukca_shared.  Of an order only the mean,
     * others NaN. */
    double mean, spread, error, value, low, high;
    int arms;
    double log_bayes_factor, probability;
} mukca_trait;

typedef struct {
    mukca_fleet_model model;
    int n, n_arms, n_sessions, n_samples;
    mukca_trait list[MUKCA_MAX_TRAITS];
} mukca_traits;

/* Least probabilities for a coefficient to be called shared and for an order to be a trait. */
#define MUKCA_COEFFICIENT_SHARED 0.5
#define MUKCA_ORDER_SHARED 0.5

/* Results of a fleet. */
typedef struct {
    mukca_population population;
    mukca_shared shared[MUKCA_FLEET_TERMS];     /* [population.n] */
    mukca_shared_order order[MUKCA_MAX_JOINTS]; /* [n_joints] */
    mukca_departure *departure, *estimate;      /* [n_arms], [n_arms][population.n] */
    mukca_traits traits;
    mukca_pool pool;
} mukca_fleet_result;

/* Pool a gathered fleet.  Arms that depart are marked and excluded from its population.  Errors:
 * MUKCA_INPUT (fewer than two arms), MUKCA_MEMORY. */
mukca_status mukca_fleet_pool(mukca_fleet_result *result, mukca_fleet *fleet, mukca_error *error);
void mukca_fleet_result_free(mukca_fleet_result *result);

#endif
