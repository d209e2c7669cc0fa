/* Log Bayes factor of a candidate from its projected normal equations. */
#ifndef MUKCA_DIAGNOSE_BAYES_FACTOR_H
#define MUKCA_DIAGNOSE_BAYES_FACTOR_H

#include "diagnose/candidate.h"

/* Log Bayes factor of a block with projected Gram G[k][k] (leading dimension k) and gradient g[k]
 * (both overwritten), averaged over prior scales, with the noise profiled out and the sign of a
 * nonnegative first coefficient taken into account.  *information (may be NULL): largest diagonal
 * entry of the effect's own terms in units, 1/rad^2. */
double mukca_bayes_factor_average(double *G, double *g, const mukca_candidate *h, double residual,
                                  int dof, double *information);

#endif
