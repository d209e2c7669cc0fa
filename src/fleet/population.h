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
    double spread[MUKCA_FLEET_TERMS]; /* standard deviation between arms, rad/(N m) */
    /* of the means: information with the arms' scatter in it, times the estimate */
    double information[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS], vector[MUKCA_FLEET_TERMS];
    /* means, none below 0, and their covariance with all coefficients present ... */
    double mean[MUKCA_FLEET_TERMS], covariance[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS];
    /* ... and averaged over which of them are 0 */
    double average[MUKCA_FLEET_TERMS];
    double average_covariance[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS];
    /* a mean given that it is not 0, with its 95 % interval */
    double value[MUKCA_FLEET_TERMS], low[MUKCA_FLEET_TERMS], high[MUKCA_FLEET_TERMS];
    int arms[MUKCA_FLEET_TERMS];                /* that inform each coefficient */
    double log_bayes_factor[MUKCA_FLEET_TERMS]; /* of a mean above 0, given the other shared ones */
    double probability[MUKCA_FLEET_TERMS];      /* that the mean is above 0 */
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

/* From information and vector: averages, values and probabilities, by an average over sets of
 * coefficients that are not 0 (A. Raftery, D. Madigan, J. Hoeting, Bayesian model averaging for
 * linear regression models, J. Am. Stat. Assoc. 92, 1997). */
void mukca_population_average(mukca_population *population);

/* A coefficient of the population, described. */
typedef struct {
    mukca_effect effect;
    double mean, error;      /* with all coefficients present; its standard error, rad/(N m) */
    double value, low, high; /* given that it is not 0, and averaged over which others are; 95 % */
    double spread;
    int arms;
    double log_bayes_factor; /* of a mean above 0, given the other shared coefficients */
    double probability;      /* that it is above 0 */
} mukca_shared;

/* shared[population->n]: all coefficients of a fitted population. */
void mukca_population_describe(mukca_shared *shared, const mukca_population *population,
                               const mukca_fleet *fleet);

#endif
