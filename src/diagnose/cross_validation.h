/* Held-out errors: of cross-validation, and of test data. */
#ifndef MUKCA_DIAGNOSE_CROSS_VALIDATION_H
#define MUKCA_DIAGNOSE_CROSS_VALIDATION_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

/* Held-out mean error of the present model, unknown functions included, m; NaN: no folds. */
double mukca_cross_validation_structure(mukca_regression *m);

/* Leave one placement out (one socket if there is one placement; a fifth of the rows of a pose
 * log): errors of the nominal model, geometry, geometry with faults excused, all causes, and all
 * causes but one, for the diagnosis.  *geometry: fitted without causes.  Errors: MUKCA_INTERRUPTED,
 * MUKCA_MEMORY. */
mukca_status mukca_cross_validation_run(mukca_diagnosis *d, mukca_arm_state *geometry,
                                        mukca_regression *m, const mukca_diagnose_options *options,
                                        mukca_error *error);

/* Predict the rows of `test`, which no fit uses, with the nominal geometry, with one fitted without
 * causes (of_geometry[n_rows], may be NULL, receives its errors), and with the unknowns of the
 * regression.  Errors: MUKCA_MEMORY. */
mukca_status mukca_test_data_measure(mukca_diagnosis *d, double *of_geometry,
                                     const mukca_regression *m, const mukca_arm_state *geometry,
                                     const mukca_dataset *test, mukca_error *error);

#endif
