/* Measured poses: their positions are residuals of observe.h; orientations are 3 more residuals per
 * sample, the rotation vector from the measured orientation times MUKCA_METRES_PER_RADIAN. */
#ifndef MUKCA_FIT_POSES_H
#define MUKCA_FIT_POSES_H

#include "fit/observe.h"

/* Weight of orientations against positions: good trackers measure to 0.1 mm and 1 mrad, which are
 * equivalent at the end of a tool of 0.1 m. */
#define MUKCA_METRES_PER_RADIAN 0.1

/* Add those of the data, which must outlive them, if any: one more group; and memory for the
 * Jacobian of n parameters.  False: out of memory. */
bool mukca_poses_add(mukca_observations *observations, mukca_pool *pool, const mukca_dataset *data,
                     int n);

/* Without measured orientations the functions below have no effect and return 0. */

/* Compute the residuals after mukca_observe_predict. */
void mukca_orientations_predict(mukca_observations *observations);

/* Sum of the squares, m^2, weighted or not. */
double mukca_orientations_squares(mukca_observations *observations, bool weighted);

/* Add to the gradient[n] of the weighted sum. */
void mukca_orientations_gradient(double *gradient, mukca_observations *observations);

/* ---- residuals as one vector, and their Jacobian ---- */

/* Residuals r[n_residuals] and their Jacobian J[n_residuals][n] (NULL: not wanted) at theta. */
void mukca_observe_residuals(double *r, double *J, mukca_observations *observations,
                             const double *theta);

/* Jacobians with respect to the n free parameters at theta: of the tip's position, J[3 * rows][n],
 * and of its orientation (rotation vector in base coordinates), JO[3 * rows][n] or NULL. Needs
 * mukca_sweep_forward; overwrites h and Q. */
void mukca_sweep_jacobian(double *J, double *JO, mukca_sweep *sweep, const double *theta,
                          const mukca_parameters *parameters, mukca_gradient gradient);

#endif
