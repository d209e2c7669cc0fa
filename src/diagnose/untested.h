/* What a recording cannot test at all, and why. */
#ifndef MUKCA_DIAGNOSE_UNTESTED_H
#define MUKCA_DIAGNOSE_UNTESTED_H

#include "diagnose/candidates.h"
#include "diagnose/diagnose.h"

/* Add the effects that have no candidate, as a whole or at a joint, to diagnosis->tested with what
 * is missing. */
void mukca_untested_add(mukca_diagnosis *diagnosis, const mukca_recording *recording,
                        const mukca_candidates *all);

/* Rows in use that do not repeat the row before them in their socket. */
int mukca_untested_distinct(const mukca_recording *recording);

/* The verdict `untestable`, for that reason. */
void mukca_untested_all(mukca_diagnosis *diagnosis, const char *why);

/* Why a candidate that was scored cannot be seen. */
const char *mukca_untested_faint(int kind, int joint);

#endif
