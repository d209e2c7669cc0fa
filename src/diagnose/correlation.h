/* Correlation of what two candidates do to a recording, after the present model is projected out.
 */
#ifndef MUKCA_DIAGNOSE_CORRELATION_H
#define MUKCA_DIAGNOSE_CORRELATION_H

#include "diagnose/projector.h"

/* Largest canonical correlation of two candidates, after all that the aimed projector projects out;
 * NaN where it is not defined. */
double mukca_correlation_canonical(mukca_projector *projector, const mukca_candidate *a,
                                   const mukca_candidate *b);

#endif
