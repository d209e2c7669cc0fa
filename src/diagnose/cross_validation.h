/* How far the gap shrinks, measured on rows that took no part in the fit. */
#ifndef MUKCA_DIAGNOSE_CROSS_VALIDATION_H
#define MUKCA_DIAGNOSE_CROSS_VALIDATION_H

#include "diagnose/diagnose.h"
#include "diagnose/model.h"

/* All held-out figures as not measurable. */
void gap_held_out_nothing(mukca_diagnosis *diagnosis);

/* Held-out mean error of the model as it stands, unknown functions included, m; NaN without folds.
 */
double gap_held_out_structure(gap_model *m);

/* Leave one placement out (one socket, where there is one placement; a fifth of the rows of a pose
 * log): nominal, geometry, faults excused, explained, and each cause alone; and the held-out data
 * of options->test.  The model is left as it was.  Errors: MUKCA_INTERRUPTED, MUKCA_MEMORY. */
mukca_status gap_held_out(mukca_diagnosis *diagnosis, gap_model *m,
                          const mukca_diagnose_options *options, mukca_error *error);

#endif
