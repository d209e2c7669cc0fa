/* What of a diagnosis can be applied to other configurations of the arm. */
#ifndef MUKCA_DIAGNOSE_APPLIED_H
#define MUKCA_DIAGNOSE_APPLIED_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

/* Drop unknown functions, let each elastic cause have one coefficient at the masses as they are
 * named, fit again, and fill `applied` with the standard errors.  The regression is changed. */
void mukca_applied_fit(mukca_applied *applied, mukca_regression *m);

#endif
