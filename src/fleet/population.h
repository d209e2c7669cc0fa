/* The population of a fleet's coefficients: those of each arm, scattered about a common mean.
 *
 * Random effects with known information per arm (N. Laird, J. Ware, Random-effects models for
 * longitudinal data, Biometrics 38, 1982): c_arm ~ N(mean, diag(spread^2)), mean >= 0.
 */
#ifndef MUKCA_FLEET_POPULATION_H
#define MUKCA_FLEET_POPULATION_H

#include "fleet/fleet.h"

typedef struct {
    int n; /* coefficients on which at least one arm has information */
    int term[MUKCA_FLEET_TERMS];
    int n_arms;
    double spread[MUKCA_FLEET_TERMS]; /* standard deviation between arms, rad/(N m) */
    /* Of the means: information, including the arms' scatter, and information times estimate. */
    double information[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS], vector[MUKCA_FLEET_TERMS];
    /* Non-negative means and their covariance, with all coefficients present. */
    double mean[MUKCA_FLEET_TERMS], covariance[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS];
    /* The same, averaged over the sets of nonzero means. */
    double average[MUKCA_FLEET_TERMS];
    double average_covariance[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS];
    /* A mean given that it is not 0, with its 95 % interval. */
    double value[MUKCA_FLEET_TERMS], low[MUKCA_FLEET_TERMS], high[MUKCA_FLEET_TERMS];
    int arms[MUKCA_FLEET_TERMS];                /* number of arms with information on it */
    double log_bayes_factor[MUKCA_FLEET_TERMS]; /* of a mean above 0, given the other shared ones */
    double probability[MUKCA_FLEET_TERMS];      /* that the mean is above 0 */
} mukca_population;

/* Evidence of one arm on the population's coefficients: information [n][n] and vector [n]. */
typedef struct {
    double L[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS], e[MUKCA_FLEET_TERMS];
} mukca_arm_evidence;

void mukca_population_arm(mukca_arm_evidence *evidence, const mukca_population *population,
                          const mukca_fleet *fleet, int arm);

/* Its information on the mean, if the arm varies about the mean with covariance V[n][n]: W =
 * (inverse(L) + V)^-1, w = W inverse(L) e.  False: V is not positive definite. */
bool mukca_population_scatter(mukca_arm_evidence *out, const mukca_arm_evidence *arm,
                              const double *V, int n);

/* Fit the population to all arms but those that depart and `without` (-1: none), starting from the
 * present mean and spread if `warm`.  False: no memory. */
bool mukca_population_fit(mukca_population *population, const mukca_fleet *fleet, int without,
                          bool warm);

/* Compute averages, values and probabilities from information and vector by model averaging over
 * the sets of nonzero coefficients (A. Raftery, D. Madigan, J. Hoeting, Bayesian model averaging
 * for linear regression models, J. Am. Stat. Assoc. 92, 1997).  False: no memory. */
bool mukca_population_average(mukca_population *population);

#endif
