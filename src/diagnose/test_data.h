/* Errors on test data, which no fit uses (--test). */
#ifndef MUKCA_DIAGNOSE_TEST_DATA_H
#define MUKCA_DIAGNOSE_TEST_DATA_H

#include "diagnose/regression.h"

/* Mean errors, m; NaN: not measurable. */
typedef struct {
    double nominal_m, geometry_m, explained_m;
    int n_placements;
    double *placement_m;                        /* [n_placements] of explained_m, NULL: none */
    double *before_m, *of_geometry_m, *after_m; /* [n_rows] of the three */
} mukca_test_errors;

/* Predict the rows of `test` with the nominal geometry, with one fitted without causes, and with
 * the unknowns of the regression.  placement_m comes from `pool`.  Errors: MUKCA_MEMORY. */
mukca_status mukca_test_data_measure(mukca_test_errors *errors, mukca_pool *pool,
                                     const mukca_regression *m,
                                     const mukca_arm_state *geometry_only,
                                     const mukca_dataset *test, mukca_error *error);

#endif
