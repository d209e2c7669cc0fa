/* Residuals of positions and orientations as one vector, and their Jacobian: 3 per sample in the
 * dataset's order (observe.h); if there are orientations, 3 per sample of them (orientations.h);
 * one per pair of sockets. */
#ifndef MUKCA_FIT_OBSERVE_JACOBIAN_H
#define MUKCA_FIT_OBSERVE_JACOBIAN_H

#include "fit/poses.h"

/* Residuals r[n_residuals] and their Jacobian J[n_residuals][n] (NULL: not wanted) at theta. */
void mukca_observe_residuals(double *r, double *J, mukca_observations *observations,
                             const double *theta, const mukca_parameters *parameters,
                             mukca_gradient kind);

/* Square roots of the weights of the residuals, weight[n_residuals]; pairs have pair_weight. */
void mukca_observe_weights(double *weight, const mukca_observations *observations,
                           double pair_weight);

#endif
