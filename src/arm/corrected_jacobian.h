/* Jacobian of the corrected arm. */
#ifndef MUKCA_ARM_CORRECTED_JACOBIAN_H
#define MUKCA_ARM_CORRECTED_JACOBIAN_H

#include "effect/equilibrium.h"

/* J[6][n_joints] as mukca_corrected_jacobian has it, at a posture that mukca_equilibrium_find has
 * found, with its slopes (both are changed). */
void mukca_corrected_differentiate(double *J, mukca_equilibrium *at, mukca_effect_slopes *slopes);

#endif
