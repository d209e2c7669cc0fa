/* Cross-validation: reduction of the error on held-out samples. */
#ifndef MUKCA_DIAGNOSE_CROSS_VALIDATION_H
#define MUKCA_DIAGNOSE_CROSS_VALIDATION_H

#include "diagnose/verdict.h"

/* Mean errors, m; NaN: not measurable. */
typedef struct {
    int folds;
    double nominal_m, geometry_m, faults_excused_m, explained_m;
    double surprise, surprise_sigmas;     /* as in mukca_diagnosis */
    mukca_shrink shrink;                  /* from faults_excused_m to explained_m */
    mukca_shrink cause[MUKCA_MAX_CAUSES]; /* from all identified causes but this one, to all */
    double rung_m[MUKCA_MAX_CAUSES];      /* with each identified cause and those before it */
    double noise_shrink_percent; /* expected gain of the catalogue's best candidate on pure noise */
    double axis_rms_m[3]; /* remaining error of the fitted geometry, by base axis; not held out */
    double *placement_m;  /* [n_placements] of explained_m, NULL: none */
    double *before_m, *after_m; /* [n_rows] errors without faulty samples, nominal and explained */
    mukca_arm_state geometry;   /* fitted without causes */
} mukca_validation;

/* Set all results to not measured. */
void mukca_cross_validation_clear(mukca_validation *validation);

/* Held-out mean error of the present model, unknown functions included, m; NaN: no folds. */
double mukca_cross_validation_structure(mukca_regression *m);

/* Leave one placement out (one socket if there is one placement; a fifth of the rows of a pose
 * log): errors of the nominal model, geometry, geometry with faults excused, all causes, and all
 * causes but one.  placement_m comes from `pool`.  Errors:
 * MUKCA_INTERRUPTED, MUKCA_MEMORY. */
mukca_status mukca_cross_validation_run(mukca_validation *validation, mukca_pool *pool,
                                        mukca_regression *m, const mukca_findings *findings,
                                        const mukca_diagnose_options *options, mukca_error *error);

#endif
