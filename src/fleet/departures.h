/* Arms that depart from their fleet. */
#ifndef MUKCA_FLEET_DEPARTURES_H
#define MUKCA_FLEET_DEPARTURES_H

#include "fleet/population.h"

/* A coefficient of an arm, from its data, compared with its sisters. */
typedef struct {
    int arm, k; /* k: index into the population's coefficients */
    mukca_effect effect;
    double value, low, high; /* of the arm, rad/(N m), 95 % */
    double mean;             /* of its sisters */
    double ratio;            /* value / mean; infinite if the mean is 0 */
    double log_bayes_factor; /* of a departure against the scatter of its sisters */
    double probability;      /* corrected for the numbers of arms and coefficients */
} mukca_departure;

/* departure[n_arms]: the most deviant coefficient of each arm, by the posterior predictive of all
 * others; `estimates` (NULL: not wanted) [n_arms][population->n] gets each arm's own coefficients
 * (value, low, high) with its sisters as prior.  False: no memory. */
bool mukca_departures_find(mukca_departure *departure, mukca_departure *estimates,
                           const mukca_population *population, const mukca_fleet *fleet);

/* Least probability for an arm to be called departing. */
#define MUKCA_DEPARTS 0.95

#endif
