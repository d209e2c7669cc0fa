/* Gaussian prior of the geometry and its posterior given samples.
 *
 * Information form: L L' = J'J / noise^2 + diag(1 / sigma^2), for the advice while recording and
 * for planning.  The diagnosis chooses its priors by the evidence (diagnose/evidence.c).
 */
#ifndef MUKCA_FIT_POSTERIOR_H
#define MUKCA_FIT_POSTERIOR_H

#include "fit/linearisation.h"

/* Prior standard deviations of an uncalibrated robot, m and rad: 1 to 8 mm and mrad were measured
 * on eleven arms (docs/method.md). */
#define MUKCA_PRIOR_LENGTH 3e-3
#define MUKCA_PRIOR_ANGLE 3e-3

/* The same for a tool mounted by hand (last fixed joint), m and rad. */
#define MUKCA_PRIOR_TOOL 2e-2

/* Prior sigma[n] of the free parameters. */
void mukca_posterior_prior(double *sigma, const mukca_linearisation *at);

/* L[n][n], the Cholesky factor of the information; gram[n][n] is J'J of the samples. */
void mukca_posterior_factor(double *L, const double *gram, const double *sigma, double noise,
                            int n);

/* Variance of a' x: |L^-1 a|^2; a[n] is overwritten. */
double mukca_posterior_variance(const double *L, double *a, int n);

#endif
