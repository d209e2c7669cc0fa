/* What of a diagnosis can be applied to other configurations of the arm. */
#ifndef MUKCA_DIAGNOSE_APPLIED_H
#define MUKCA_DIAGNOSE_APPLIED_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

/* Fill diagnosis->applied: drop unknown functions, let each elastic cause have one coefficient at
 * the masses as they are named, fit again, and tell standard errors.  The model is changed. */
void mukca_applied_fit(mukca_diagnosis *diagnosis, mukca_regression *m);

#endif
