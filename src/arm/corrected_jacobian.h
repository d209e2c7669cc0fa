/* Jacobian of the corrected arm. */
#ifndef MUKCA_ARM_CORRECTED_JACOBIAN_H
#define MUKCA_ARM_CORRECTED_JACOBIAN_H

#include "effect/equilibrium.h"

/* J[6][n_joints] of mukca_corrected_jacobian() at the posture and slopes of
 * mukca_equilibrium_find() (both are overwritten). */
void mukca_corrected_differentiate(double *J, mukca_equilibrium *at, mukca_effect_slopes *slopes);

#endif
