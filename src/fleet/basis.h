/* Coefficients shared by arms of one model: all elastic coefficients of the chain. */
#ifndef MUKCA_FLEET_BASIS_H
#define MUKCA_FLEET_BASIS_H

#include "diagnose/regression.h"

/* Compliance of each joint, link bending before each but the first, and the compliance of the base,
 * which precedes the first. */
enum { MUKCA_FLEET_TERMS = 2 * MUKCA_MAX_JOINTS };

/* Half-width of a 95 % interval in sigmas: the 0.975 quantile of the normal distribution. */
#define MUKCA_FLEET_INTERVAL 1.959963984540054

/* Prior of a coefficient, rad/(N m). */
typedef struct {
    double mean, sigma;
} mukca_fleet_prior;

/* Number of coefficients, and the i-th (without value). */
int mukca_fleet_terms(int n_joints);
mukca_effect mukca_fleet_term(int i, int n_joints);

/* Remove from the regression all elastic causes, unknown functions, which would absorb elasticity,
 * and the gear harmonics of a joint (-1: none). */
void mukca_fleet_strip(mukca_regression *m, int joint);

/* Append the elastic coefficients to the causes, with prior[terms], each with one coefficient for
 * all masses.  A coefficient without influence on this recording is omitted.  Fit afterwards.
 * False: no space. */
bool mukca_fleet_add(mukca_regression *m, const mukca_fleet_prior *prior);

/* Index of a gear harmonic among the causes; added if absent, with a prior size chosen by evidence;
 * -1: no space. */
int mukca_fleet_add_harmonic(mukca_regression *m, int joint, int order);

#endif
