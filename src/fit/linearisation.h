/* The geometry at a point of its parameters, and the tip's derivatives by the free ones there.
 *
 * One row at a time, for what looks at single postures: capture's advice and planning.  The
 * calibration differentiates all rows at once (sweep.h); the tests compare the two.  The diagnosis
 * has columns of its own (diagnose/linearisation.c): local frames, in which its prior is the same
 * for every joint, and levers for the effects.
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

/* Move to theta[6 * n_elements], which may be at->theta itself. */
void mukca_linearisation_move(mukca_linearisation *at, const double *theta);

/* Position of the tip, m (may be NULL), and its derivatives J[3][ld] by the n free parameters (m/m,
 * m/rad), in the first n columns. */
void mukca_linearisation_tip(double *J, int ld, double position[3], const mukca_linearisation *at,
                             const double *q);

#endif
