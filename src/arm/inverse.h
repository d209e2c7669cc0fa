/* Inverse kinematics: joint angles within the limits that bring the tip to a position or a pose. */
#ifndef MUKCA_ARM_INVERSE_H
#define MUKCA_ARM_INVERSE_H

#include <stdbool.h>

#include "mukca/chain.h"

/* Zeroed: 100 steps, 1e-9 m and rad, no effects. */
typedef struct {
    int max_steps;
    double tolerance; /* m, and rad if a rotation is given */
    /* displacement by effects at q, or NULL */
    void (*displace)(mukca_displacement *displacement, const double *q, void *context);
    void *context; /* of `displace` */
} mukca_inverse_options;

typedef struct {
    bool reached; /* within the tolerance */
    bool limited; /* a joint is at its limit */
    int steps;
    double position_error; /* m, |target - reached| */
    double rotation_error; /* rad; 0 without a rotation */
} mukca_inverse_result;

/* Bring the tip to target->p (`with_rotation`: and target->R) by damped least squares.
 * q[n_joints]: start in, closest solution out.  Does not allocate. */
mukca_inverse_result mukca_inverse_solve(double *q, const mukca_chain *chain,
                                         const mukca_geometry *geometry, const mukca_frame *target,
                                         bool with_rotation, const mukca_inverse_options *options);

#endif
