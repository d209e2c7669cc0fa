/* Held-out errors: fits without a part of the rows (a fold) that predict it, and test data. */
#ifndef MUKCA_DIAGNOSE_HELD_OUT_H
#define MUKCA_DIAGNOSE_HELD_OUT_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

/* ---- folds (folds.c) ---- */

typedef struct {
    mukca_regression *m;
    int n_folds;
    int *fold;                   /* [n_rows] */
    mukca_normal_equations rest; /* without one fold */
    double *position; /* [n_rows][3] prediction of each row without its fold; NaN: a row in no fold
                         (fewer poses than folds) */
    double *error;    /* [n_rows]; NaN: not measured */
    int *start, *row; /* [n_sockets + 2], [n_rows] scratch: rows by socket */
} mukca_folds;

/* Allocate from b->m's pool (check pool.failed). */
void mukca_folds_create(mukca_folds *b);

/* fold[n_rows] by placement, else (or by_socket) by socket, else by block of a pose log.  Returns
 * the number of folds. */
int mukca_folds_assign(int *fold, const mukca_regression *m, bool by_socket);

/* error[n_rows], m: distance of each row's prediction position[n_rows][3] from its socket's mean,
 * over the rows marked in `marked` (NULL: all; others: NaN); with `excuse` from the mean of each
 * segment or the creep line of a known fault of the tool.  For poses the distance from the
 * measurement, in its frame. */
void mukca_folds_errors(double *error, const mukca_regression *m, const double *position,
                        const unsigned char *marked, bool excuse);

/* mean[n_placements] of the finite errors of each placement's rows; NaN: none. */
void mukca_folds_by_placement(double *mean, const mukca_recording *recording, const double *error);

/* Mean of the finite values of error[n]; NaN: none. */
double mukca_folds_mean(const double *error, int n);

/* error[n_rows] of the kept rows, each predicted without its fold (placement, or by_socket socket)
 * by the linearised regression. */
void mukca_folds_run(double *error, mukca_folds *b, bool by_socket);

/* Reduction of the mean error from before[n_rows] to after[n_rows], with a bootstrap interval. */
void mukca_folds_compare(mukca_shrink *shrink, const mukca_folds *b, const double *before,
                         const double *after);

/* ---- errors of a diagnosis (held_out.c, test_data.c) ---- */

/* Held-out mean error of the present model, unknown functions included, m; NaN: no folds. */
double mukca_held_out_structure(mukca_regression *m);

/* Leave one placement out (one socket if there is one placement; a tenth of the rows of a pose
 * log): errors of the nominal model, geometry, geometry with faults excused, all causes, and all
 * causes but one, for the diagnosis.  *geometry: fitted without causes.  Errors: MUKCA_INTERRUPTED,
 * MUKCA_MEMORY. */
mukca_status mukca_held_out_run(mukca_diagnosis *d, mukca_arm_state *geometry, mukca_regression *m,
                                const mukca_diagnose_options *options, mukca_error *error);

/* Predict the rows of `test`, which no fit uses, with the nominal geometry, with one fitted without
 * causes (of_geometry[n_rows], may be NULL, receives its errors), and with the unknowns of the
 * regression.  Errors: MUKCA_MEMORY. */
mukca_status mukca_test_data_measure(mukca_diagnosis *d, double *of_geometry,
                                     const mukca_regression *m, const mukca_arm_state *geometry,
                                     const mukca_dataset *test, mukca_error *error);

#endif
