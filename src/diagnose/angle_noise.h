/* What the noise in the recorded angles alone adds to the score of a candidate. */
#ifndef MUKCA_DIAGNOSE_ANGLE_NOISE_H
#define MUKCA_DIAGNOSE_ANGLE_NOISE_H

#include "diagnose/projector.h"

/* By how much the log Bayes factor of a candidate with a basis is too high, by the aimed projector;
 * 0 where memory is short. */
double mukca_angle_noise_gain(mukca_projector *projector, const mukca_candidate *candidate);

#endif
