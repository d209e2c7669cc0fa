/* Gaussian prior of the geometry and its posterior given samples.
 *
 * Information form: L L' = J'J / noise^2 + diag(1 / sigma^2), for the advice while recording and
 * for planning.  The diagnosis chooses its priors by the evidence (diagnose/evidence.c).
 *
 * The linearisation is of one posture at a time; the calibration differentiates all samples at once
 * (sweep.h), the diagnosis has its own columns (diagnose/linearisation.c).
 */
#ifndef MUKCA_FIT_POSTERIOR_H
#define MUKCA_FIT_POSTERIOR_H

#include "fit/parameters.h"

/* Prior standard deviations of an uncalibrated robot, m and rad: 1 to 8 mm and mrad were measured
 * on eleven arms (docs/method.md). */
#define MUKCA_PRIOR_LENGTH 3e-3
#define MUKCA_PRIOR_ANGLE 3e-3

/* The same for a tool mounted by hand (last fixed joint), m and rad. */
#define MUKCA_PRIOR_TOOL 2e-2

typedef struct {
    const mukca_chain *chain;
    mukca_parameters parameters;
    double theta[MUKCA_MAX_FREE]; /* [6 * n_elements] */
    mukca_geometry geometry;      /* of theta */
} mukca_linearisation;

/* The default parameters at theta[6 * n_elements] (NULL: nominal); `chain` must outlive it. */
void mukca_linearisation_init(mukca_linearisation *at, const mukca_chain *chain,
                              const double *theta);

/* Move to theta[6 * n_elements], at->theta itself is allowed. */
void mukca_linearisation_move(mukca_linearisation *at, const double *theta);

/* Position of the tip, m (may be NULL), and its Jacobian J[3][ld] with respect to the n free
 * parameters (m/m, m/rad), in the first n columns. */
void mukca_linearisation_tip(double *J, int ld, double position[3], const mukca_linearisation *at,
                             const double *q);

/* Prior sigma[n] of the free parameters. */
void mukca_posterior_prior(double *sigma, const mukca_chain *chain,
                           const mukca_parameters *parameters);

/* L[n][n], the Cholesky factor of the information; gram[n][n] is J'J of the samples. */
void mukca_posterior_factor(double *L, const double *gram, const double *sigma, double noise,
                            int n);

/* Variance of a' x: |L^-1 a|^2; a[n] is overwritten. */
double mukca_posterior_variance(const double *L, double *a, int n);

#endif
