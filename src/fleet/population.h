/* The population of a fleet's coefficients: each arm's own, scattered about a common mean.
 *
 * Random effects with known information per arm (N. Laird, J. Ware, Random-effects models for
 * longitudinal data, Biometrics 38, 1982): c_arm ~ N(mean, diag(spread^2)), mean >= 0.
 */
#ifndef MUKCA_FLEET_POPULATION_H
#define MUKCA_FLEET_POPULATION_H

#include "fleet/fleet.h"

typedef struct {
    int n; /* coefficients that some arm's data inform */
    int term[MUKCA_FLEET_TERMS];
    int n_arms;
    double mean[MUKCA_FLEET_TERMS];   /* rad/(N m) */
    double spread[MUKCA_FLEET_TERMS]; /* standard deviation between arms */
    /* of the mean: information with the arms' scatter in it, times the estimate, covariance */
    double information[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS], vector[MUKCA_FLEET_TERMS];
    double covariance[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS];
    int arms[MUKCA_FLEET_TERMS]; /* that inform each coefficient */
} mukca_population;

/* What one arm says, in the population's coefficients: information [n][n] and vector [n]. */
typedef struct {
    double L[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS], e[MUKCA_FLEET_TERMS];
} mukca_arm_evidence;

void mukca_population_arm(mukca_arm_evidence *evidence, const mukca_population *population,
                          const mukca_fleet *fleet, int arm);

/* The information that it gives on its mean where it varies about that with covariance
 * V[n][n]: W = (inverse(L) + V)^-1, w = W inverse(L) e.  False: V is not positive definite. */
bool mukca_population_scatter(mukca_arm_evidence *out, const mukca_arm_evidence *arm,
                              const double *V, int n);

/* Fit the population to all arms but those that depart and `without` (-1: none), from the present
 * mean and spread on where `warm`. */
void mukca_population_fit(mukca_population *population, const mukca_fleet *fleet, int without,
                          bool warm);

/* A coefficient of the population, described. */
typedef struct {
    mukca_effect effect;
    double mean, error, low, high; /* standard error and 95 % interval of the mean, rad/(N m) */
    double spread;
    int arms;
    double log_bayes_factor; /* of a mean above 0, given the other shared coefficients */
    double probability;      /* that it is shared: against all other coefficients, and none */
} mukca_shared;

/* shared[population->n]: which coefficients the fleet shares, by a forward and a backward search
 * with the population's scatter. */
void mukca_population_describe(mukca_shared *shared, const mukca_population *population,
                               const mukca_fleet *fleet);

#endif
