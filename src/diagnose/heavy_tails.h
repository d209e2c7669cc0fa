/* Contribution of heavy-tailed, correlated or single-joint noise to the score of a candidate.
 */
#ifndef MUKCA_DIAGNOSE_HEAVY_TAILS_H
#define MUKCA_DIAGNOSE_HEAVY_TAILS_H

#include "diagnose/regression.h"

typedef struct {
    mukca_unknowns kept; /* saved model */
    double *scratch;     /* [4 * n_rows] */
    bool known;          /* value[] is valid for the present model without the candidate */
    /* log likelihoods under Gaussian noise; with tails and memory, or noise of a joint */
    double value[2];
} mukca_heavy_tails;

/* Memory comes from `pool`.  False: no memory. */
bool mukca_heavy_tails_create(mukca_heavy_tails *tails, mukca_pool *pool,
                              const mukca_regression *m);

/* Excess, at least 0, of a candidate's log Bayes factor under Gaussian noise over that under noise
 * with heavy tails and long memory or, for a function of a joint's angle, noise in a joint's angle.
 * `without`: cause to omit from the model, -1: none.  The model is restored.  Set tails->known to
 * false if the model, `without` or the noise has changed since the last call. */
double mukca_heavy_tails_gain(mukca_heavy_tails *tails, mukca_regression *m, int without,
                              const mukca_candidate *candidate);

#endif
