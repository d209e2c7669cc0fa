/* Contribution of noise in the recorded angles to a candidate's score. */
#ifndef MUKCA_DIAGNOSE_ANGLE_NOISE_H
#define MUKCA_DIAGNOSE_ANGLE_NOISE_H

#include "diagnose/projector.h"

/* Bias of the log Bayes factor of a candidate with a basis, for the projector's normal equations;
 * 0: no memory. */
double mukca_angle_noise_gain(mukca_projector *projector, const mukca_candidate *candidate);

#endif
