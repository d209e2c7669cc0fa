/* Canonical correlation of two candidates, with the present model projected out. */
#ifndef MUKCA_DIAGNOSE_CORRELATION_H
#define MUKCA_DIAGNOSE_CORRELATION_H

#include "diagnose/projector.h"

/* Largest canonical correlation of two candidates, with all columns of the projector projected out;
 * NaN: undefined. */
double mukca_correlation_canonical(mukca_projector *projector, const mukca_candidate *a,
                                   const mukca_candidate *b);

#endif
