/* Arms that depart from their fleet. */
#ifndef MUKCA_FLEET_DEPARTURES_H
#define MUKCA_FLEET_DEPARTURES_H

#include "fleet/population.h"

/* What an arm's own data and its sisters say of one of its coefficients. */
typedef struct {
    int arm, k; /* k: index into the population's coefficients */
    mukca_effect effect;
    double value, low, high; /* of the arm, rad/(N m), 95 % */
    double mean;             /* of its sisters */
    double ratio;            /* value / mean; infinite where they have none */
    double log_bayes_factor; /* of a departure against the scatter of its sisters */
    double probability;      /* with the number of arms and coefficients taken into account */
} mukca_departure;

/* departure[n_arms]: the coefficient in which each arm departs most, by its posterior predictive
 * from all others; `estimates` (NULL: not wanted) [n_arms][population->n] gets each arm's own
 * coefficients (value, low, high) with its sisters as prior. */
void mukca_departures_find(mukca_departure *departure, mukca_departure *estimates,
                           const mukca_population *population, const mukca_fleet *fleet);

/* From this probability on an arm departs. */
#define MUKCA_DEPARTS 0.95

#endif
