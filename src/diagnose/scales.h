/* Prior scales of geometry and causes by evidence. */
#ifndef MUKCA_DIAGNOSE_SCALES_H
#define MUKCA_DIAGNOSE_SCALES_H

#include "diagnose/evidence.h"

/* Choose the scales that maximise the evidence at the present noise: the geometry's two together,
 * then each cause's, one at a time.  evidence->prior gets the sigmas of all columns. */
void mukca_scales_choose(mukca_unknowns *unknowns, mukca_evidence *evidence,
                         const mukca_recording *recording, const mukca_normal_equations *normal);

#endif
