/* Prior scales of geometry and causes, chosen by evidence. */
#ifndef MUKCA_DIAGNOSE_SCALES_H
#define MUKCA_DIAGNOSE_SCALES_H

#include "diagnose/evidence.h"

/* Maximise the evidence over the scales at the present noise: the geometry's two together, then
 * each cause's in turn.  evidence->prior receives the prior sigmas of all columns. */
void mukca_scales_choose(mukca_unknowns *unknowns, mukca_evidence *evidence,
                         const mukca_recording *recording, const mukca_normal_equations *normal);

#endif
