/* How far the gap shrinks, measured on rows that took no part in the fit. */
#ifndef MUKCA_DIAGNOSE_CROSS_VALIDATION_H
#define MUKCA_DIAGNOSE_CROSS_VALIDATION_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

/* All held-out figures as not measurable. */
void mukca_cross_validation_clear(mukca_diagnosis *diagnosis);

/* Held-out mean error of the model as it stands, unknown functions included, m; NaN without folds.
 */
double mukca_cross_validation_structure(mukca_regression *m);

/* Leave one placement out (one socket, where there is one placement; a fifth of the rows of a pose
 * log): nominal, geometry, faults excused, explained, and each cause alone; and the held-out data
 * of options->test.  The model is left as it was.  Errors: MUKCA_INTERRUPTED, MUKCA_MEMORY. */
mukca_status mukca_cross_validation_run(mukca_diagnosis *diagnosis, mukca_regression *m,
                                        const mukca_diagnose_options *options, mukca_error *error);

#endif
