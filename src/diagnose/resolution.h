/* The step in which the angles of a joint were recorded. */
#ifndef MUKCA_DIAGNOSE_RESOLUTION_H
#define MUKCA_DIAGNOSE_RESOLUTION_H

#include "diagnose/recording.h"

/* Largest step whose multiples all recorded angles of a joint are, rad: of a coarse encoder, or of
 * the digits in the file; 0 where none is plain.  scratch[n_rows] is destroyed. */
double mukca_resolution_step(double *scratch, const mukca_recording *recording, int joint);

#endif
