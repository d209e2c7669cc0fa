/* Simple causes outside the catalogue: members of sets without a name. */
#ifndef MUKCA_DIAGNOSE_UNLISTED_H
#define MUKCA_DIAGNOSE_UNLISTED_H

#include "diagnose/candidate.h"

/* Terms of an unlisted candidate. */
int mukca_unlisted_terms(const mukca_candidate *candidate);

/* Fill its basis [n_rows][terms]. */
void mukca_unlisted_fill(const mukca_candidate *candidate, const mukca_recording *recording);

/* Columns out[3][ld], 3 wide, of a TILT candidate for the frame R[9] of the tip. */
void mukca_unlisted_tilt(double *out, int ld, const mukca_candidate *candidate, const double *R,
                         const double gravity[3]);

#endif
