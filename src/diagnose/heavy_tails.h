/* What noise that is not the same in all samples and directions adds to the score of a candidate.
 */
#ifndef MUKCA_DIAGNOSE_HEAVY_TAILS_H
#define MUKCA_DIAGNOSE_HEAVY_TAILS_H

#include "diagnose/regression.h"

typedef struct {
    mukca_unknowns kept; /* to go back to */
    double *scratch;     /* [4 * n_rows] */
    bool known;          /* value[] is that of the present model without the candidate */
    /* log likelihoods under Gaussian noise, and with tails and memory, or noise of the joint */
    double value[2];
} mukca_heavy_tails;

/* Memory comes from `pool`.  False: no memory. */
bool mukca_heavy_tails_create(mukca_heavy_tails *tails, mukca_pool *pool,
                              const mukca_regression *m);

/* By how much the log Bayes factor of a candidate, in the model without cause `without` (-1: in the
 * whole model), is higher under Gaussian noise than under noise that may have heavy tails and a
 * long memory, or for a function of a joint's angle, noise of a joint's angle.  The model is left
 * as it was; set tails->known to false when it, `without` or the noise is another one than the last
 * time.
 */
double mukca_heavy_tails_gain(mukca_heavy_tails *tails, mukca_regression *m, int without,
                              const mukca_candidate *candidate);

#endif
