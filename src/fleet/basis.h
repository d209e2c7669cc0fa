/* The coefficients that arms of one model share: every elastic coefficient of the chain. */
#ifndef MUKCA_FLEET_BASIS_H
#define MUKCA_FLEET_BASIS_H

#include "diagnose/regression.h"

/* Compliance of each joint, bending before each but the first, and the base, which is what bends
 * before the first. */
enum { MUKCA_FLEET_TERMS = 2 * MUKCA_MAX_JOINTS };

/* Sigmas on each side of a 95 % interval: the 0.975 quantile of the normal distribution. */
#define MUKCA_FLEET_INTERVAL 1.959963984540054

/* Prior of a coefficient, rad/(N m). */
typedef struct {
    double mean, sigma;
} mukca_fleet_prior;

/* Number of the coefficients, and the i-th one (without its value). */
int mukca_fleet_terms(int n_joints);
mukca_effect mukca_fleet_term(int i, int n_joints);

/* Take all elastic causes out of the regression, and unknown functions, which would stand in for
 * them, and the gear harmonics of a joint (-1: none). */
void mukca_fleet_strip(mukca_regression *m, int joint);

/* Add the elastic coefficients behind all other causes, each with its prior[terms], and one
 * coefficient for all masses; none where it deflects nothing in this recording.  Fit afterwards.
 * False: no room. */
bool mukca_fleet_add(mukca_regression *m, const mukca_fleet_prior *prior);

/* Index of a gear harmonic among the causes, added where it is none yet, its size to be chosen by
 * evidence; -1: no room. */
int mukca_fleet_add_harmonic(mukca_regression *m, int joint, int order);

#endif
