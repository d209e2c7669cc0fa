/* How well a diagnosis knows each parameter of the geometry. */
#ifndef MUKCA_STUDY_OFFSET_SIGMA_H
#define MUKCA_STUDY_OFFSET_SIGMA_H

#include "study/diagnose.h"
#include "study/gap_model.h"

/* Fill diagnosis->theta_sigma and theta_prior (in its pool) from the factor that the last evidence
 * left.  The model's unknowns are local offsets; parameters are the URDF's x y z roll pitch yaw. */
void gap_offset_sigmas(mukca_diagnosis *diagnosis, gap_model *m);

#endif
