/* Prior scales of geometry and causes, chosen by evidence. */
#ifndef MUKCA_DIAGNOSE_SCALES_H
#define MUKCA_DIAGNOSE_SCALES_H

#include "diagnose/evidence.h"

/* Maximise the evidence at the present noise over the geometry's two scales together, then over
 * that of each cause whose scale is open.  evidence->prior receives the prior sigmas of all
 * columns. */
void mukca_scales_choose(mukca_unknowns *unknowns, mukca_evidence *evidence,
                         const mukca_recording *recording, const mukca_normal_equations *normal);

#endif
