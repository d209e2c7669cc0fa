/* Simple causes that nobody listed: the rivals of a name when its probability is computed. */
#ifndef MUKCA_DIAGNOSE_UNLISTED_H
#define MUKCA_DIAGNOSE_UNLISTED_H

#include "diagnose/candidate.h"

/* Terms of an unlisted candidate. */
int mukca_unlisted_terms(const mukca_candidate *candidate);

/* Fill its basis [n_rows][terms]. */
void mukca_unlisted_fill(const mukca_candidate *candidate, const mukca_recording *recording);

#endif
