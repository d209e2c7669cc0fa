/* The joint axes of two models, each seen from the axis before it. */
#ifndef MUKCA_ARM_COMPARE_AXES_H
#define MUKCA_ARM_COMPARE_AXES_H

#include "arm/compare.h"

/* difference[n_joints] of two arms with as many joints. */
void mukca_compare_axes(mukca_axis_difference *difference, const mukca_geometry *a,
                        const mukca_geometry *b);

#endif
