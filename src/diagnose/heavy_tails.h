/* What correlated noise with heavy tails adds to the score of a candidate. */
#ifndef MUKCA_DIAGNOSE_HEAVY_TAILS_H
#define MUKCA_DIAGNOSE_HEAVY_TAILS_H

#include "diagnose/regression.h"

/* By how much the log Bayes factor of a candidate, in the model without cause `without` (-1: in the
 * whole model), is higher under Gaussian noise than under noise that may have heavy tails and a
 * long memory.  `kept` is a clone of the unknowns and is overwritten, memory is [4 * n_rows]; the
 * model is left as it was. */
double mukca_heavy_tails_gain(mukca_regression *m, mukca_unknowns *kept, double *memory,
                              int without, const mukca_candidate *candidate);

#endif
