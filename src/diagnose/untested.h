/* What a recording cannot test at all, and why. */
#ifndef MUKCA_DIAGNOSE_UNTESTED_H
#define MUKCA_DIAGNOSE_UNTESTED_H

#include "diagnose/candidates.h"
#include "diagnose/diagnose.h"

/* Add the effects that have no candidate, as a whole or at a joint, to diagnosis->tested with what
 * is missing. */
void gap_untested_add(mukca_diagnosis *diagnosis, const gap_model *m, const gap_hypotheses *all);

/* Rows in use that do not repeat the row before them in their socket. */
int gap_distinct_rows(const gap_model *m);

/* The verdict `untestable`, for that reason. */
void gap_untested_all(mukca_diagnosis *diagnosis, const char *why);

/* Why a candidate that was scored cannot be seen. */
const char *gap_untested_faint(int kind, int joint);

#endif
