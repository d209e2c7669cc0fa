/* The regression that the diagnosis reasons with: recording, unknowns, linearisation, evidence.
 *
 * Sockets' means are free, so samples and columns are centred per socket (after whitening with an
 * AR(1) coefficient) and one row per known distance is added; samples of a pose log are compared
 * with their measured tip instead.
 */
#ifndef MUKCA_DIAGNOSE_REGRESSION_H
#define MUKCA_DIAGNOSE_REGRESSION_H

#include "diagnose/evidence.h"

typedef struct mukca_regression {
    mukca_recording recording;
    mukca_unknowns unknowns;
    mukca_linearisation linear;
    mukca_evidence evidence;
    mukca_pool pool;
} mukca_regression;

/* Build the regression of a dataset; chain and data must outlive it.  Errors: MUKCA_MEMORY. */
mukca_status mukca_regression_create(mukca_regression *m, const mukca_chain *chain,
                                     const mukca_dataset *data,
                                     const mukca_recording_options *options, mukca_error *error);
void mukca_regression_free(mukca_regression *m);

/* Linearise at the present unknowns. */
void mukca_regression_linearise(mukca_regression *m);

/* Normal equations of the present columns at one AR(1) coefficient, or at that of the noise. */
mukca_normal_equations *mukca_regression_collect(mukca_regression *m, int index);
mukca_normal_equations *mukca_regression_collect_own(mukca_regression *m);

/* Evidence of the present columns, priors and noise; the factor of their posterior stays.  Returns
 * as mukca_evidence_evaluate. */
double mukca_regression_factor(mukca_regression *m);

/* Standard error of the sum of direction[t] x[column + t], t < terms, in the posterior whose factor
 * the last evaluation left. */
double mukca_regression_standard_error(mukca_regression *m, int column, const double *direction,
                                       int terms);

/* What a fit may choose besides the unknowns themselves. */
typedef enum {
    MUKCA_FIT_UNKNOWNS, /* nothing: noise, AR(1) and prior scales stay */
    MUKCA_FIT_NOISE,    /* noise and AR(1), in the first step */
    MUKCA_FIT_ALL       /* noise, AR(1) and prior scales by evidence, in the first and third step */
} mukca_fit_freedom;

/* Log posterior of the set of causes that was last fitted, up to a constant: evidence, and the
 * priors of the causes and of their sizes. */
double mukca_regression_score(mukca_regression *m);

/* Linearise at the present unknowns for a search: other sets of causes are fitted to the same
 * columns.  Then return to that linearisation with unknowns that were fitted to it before. */
void mukca_regression_freeze(mukca_regression *m);
void mukca_regression_return(mukca_regression *m);

/* Solve for the unknowns on the frozen columns, at the noise and the prior scales that they have.
 * False: the normal equations cannot be factored. */
bool mukca_regression_solve(mukca_regression *m);

/* Choose noise, AR(1) and prior scales by evidence on the frozen columns; no unknown changes. */
void mukca_regression_weigh(mukca_regression *m);

/* Fit all unknowns, as MUKCA_FIT_ALL, to the frozen columns; freezes anew where these do not hold
 * for the result. */
void mukca_regression_refit(mukca_regression *m);

/* Fit the unknowns alone after causes were dropped, noise and prior scales staying: to the columns
 * that are there, with predictions anew, where these hold for the result, else as
 * MUKCA_FIT_UNKNOWNS.
 */
void mukca_regression_revise(mukca_regression *m);

/* One Gauss-Newton step from the present linearisation; ends linearised at the new unknowns. */
void mukca_regression_step(mukca_regression *m, mukca_fit_freedom freedom);

/* Fit geometry and causes in at most `iterations` Gauss-Newton steps.  Ends linearised at the
 * unknowns, or a last step of 0.1 um before them. */
void mukca_regression_fit(mukca_regression *m, int iterations, mukca_fit_freedom freedom);

#endif
