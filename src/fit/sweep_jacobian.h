/* Sweeps over many samples at once: orientations and the Jacobian. */
#ifndef MUKCA_FIT_SWEEP_JACOBIAN_H
#define MUKCA_FIT_SWEEP_JACOBIAN_H

#include "fit/sweep.h"

/* Compute Q, the tip's orientation in the base, for the origins in use. */
void mukca_sweep_orientations(mukca_sweep *sweep);

/* Angular velocity of a rotation R with derivative dR: the antisymmetric part of dR R'. */
void mukca_sweep_spin(double omega[3], const double dR[9], const double R[9]);

/* Jacobians with respect to the n free parameters at theta: of the tip's position, J[3 * rows][n],
 * and of its orientation (rotation vector in base coordinates), JO[3 * rows][n] or NULL. Needs
 * mukca_sweep_forward; overwrites x and Q. */
void mukca_sweep_jacobian(double *J, double *JO, mukca_sweep *sweep, const double *theta,
                          const mukca_parameters *parameters, mukca_gradient gradient);

#endif
