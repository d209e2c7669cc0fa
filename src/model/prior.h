/* Prior standard deviations of an arm's geometry about its nominal model. */
#ifndef MUKCA_MODEL_PRIOR_H
#define MUKCA_MODEL_PRIOR_H

#include <stdbool.h>

typedef struct {
    double length, angle; /* of each axis, m and rad */
    double zero;          /* of a joint's zero, rad, where it is not one of the angles; else 0 */
    double common;        /* of a factor common to all lengths; 0: none */
    double tool;          /* of the last fixed joint, mounted by hand and not measured, m and rad */
} mukca_geometry_prior;

/* An uncalibrated robot, for planning, acceptance and advice: 1 to 8 mm and mrad were measured on
 * eleven arms (docs/method.md). */
static const mukca_geometry_prior mukca_prior_expected = {3e-3, 3e-3, 0, 0, 20e-3};

/* The measurement noise, m: the repeatability of a printed socket is 0.1 to 0.2 mm. */
#define MUKCA_PRIOR_NOISE 1.5e-4

/* Start of the diagnosis, which chooses lengths and angles by the evidence (mukca_scales_choose);
 * real arms have zeros of up to 15 mrad.  The priors of single lengths constrain their sum weakly:
 * without the factor, a wrong distance of the sockets would change the size of the arm. */
static const mukca_geometry_prior mukca_prior_diagnosed = {2e-3, 5e-3, 20e-3, 2e-3, 20e-3};

/* Of parameter i, 0..5: x y z roll pitch yaw; `tool`: of the last fixed joint. */
static inline double mukca_prior_sigma(const mukca_geometry_prior *prior, int i, bool tool)
{
    return tool ? prior->tool : i < 3 ? prior->length : prior->angle;
}

#endif
