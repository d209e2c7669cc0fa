/* The geometry at given parameters, and the derivatives of the tip with respect to the free ones.
 *
 * One posture at a time, for the advice while recording and for planning.  The calibration
 * differentiates all samples at once (sweep.h); the tests compare the two.  The diagnosis has its
 * own columns (diagnose/linearisation.c): in local frames, with the same prior at every joint, and
 * with lever arms for the effects.
 */
#ifndef MUKCA_FIT_LINEARISATION_H
#define MUKCA_FIT_LINEARISATION_H

#include "fit/parameters.h"

typedef struct {
    const mukca_chain *chain;
    mukca_parameters parameters;
    double theta[MUKCA_MAX_FREE]; /* [6 * n_elements] */
    mukca_geometry geometry;      /* of theta */
} mukca_linearisation;

/* The default parameters at theta[6 * n_elements] (NULL: nominal); `chain` must outlive it.
 * Errors: MUKCA_USAGE (no joint). */
mukca_status mukca_linearisation_init(mukca_linearisation *at, const mukca_chain *chain,
                                      const double *theta, mukca_error *error);

/* Move to theta[6 * n_elements], at->theta itself is allowed. */
void mukca_linearisation_move(mukca_linearisation *at, const double *theta);

/* Position of the tip, m (may be NULL), and its Jacobian J[3][ld] with respect to the n free
 * parameters (m/m, m/rad), in the first n columns. */
void mukca_linearisation_tip(double *J, int ld, double position[3], const mukca_linearisation *at,
                             const double *q);

#endif
