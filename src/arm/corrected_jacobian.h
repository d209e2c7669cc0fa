/* The derivative of the corrected arm's pose. */
#ifndef MUKCA_ARM_CORRECTED_JACOBIAN_H
#define MUKCA_ARM_CORRECTED_JACOBIAN_H

#include "effect/slopes.h"
#include "mukca/corrected.h"

typedef struct {
    const mukca_corrected *model;
    const double *q;
    const mukca_displacement *displacement; /* of the model's effects at q */
    /* by angle; by load where `loaded`: torques that are given do not change */
    mukca_effect_slopes *slopes;
    bool loaded;
    double payload_kg;
} mukca_corrected_point;

/* J[6][n_joints] as mukca_corrected_jacobian has it, and the pose (may be NULL). */
void mukca_corrected_differentiate(double *J, mukca_frame *T_base_tip,
                                   const mukca_corrected_point *at);

#endif
