/* Resolution of the recorded angles of a joint. */
#ifndef MUKCA_DIAGNOSE_RESOLUTION_H
#define MUKCA_DIAGNOSE_RESOLUTION_H

#include "diagnose/recording.h"

/* Largest step of which all recorded angles of a joint are multiples, rad: of a coarse encoder, or
 * of the digits in the file; 0: no evident step.  scratch[n_rows] is overwritten. */
double mukca_resolution_step(double *scratch, const mukca_recording *recording, int joint);

#endif
