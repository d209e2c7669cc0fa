/* Part of a diagnosis that applies to other configurations of the arm. */
#ifndef MUKCA_DIAGNOSE_APPLIED_H
#define MUKCA_DIAGNOSE_APPLIED_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

/* Drop unknown functions, reduce each elastic cause to one coefficient at the nominal masses, fit
 * again, and fill `applied` with the result and its standard errors.  The regression is changed. */
void mukca_applied_fit(mukca_applied *applied, mukca_regression *m);

#endif
