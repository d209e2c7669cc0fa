/* Regression of the diagnosis: recording, unknowns, linearisation, evidence.
 *
 * The means of the sockets are free: samples and columns are centred per socket, after whitening
 * by the family of the noise, and each known distance adds one row.  Samples of a pose log are
 * compared with their measured tip instead. */
#ifndef MUKCA_DIAGNOSE_REGRESSION_H
#define MUKCA_DIAGNOSE_REGRESSION_H

#include "base/workers.h"
#include "diagnose/evidence.h"

typedef struct mukca_regression {
    mukca_recording recording;
    mukca_unknowns unknowns;
    mukca_linearisation linear;
    mukca_evidence evidence;
    mukca_pool pool;
} mukca_regression;

/* Create the regression of a dataset; chain and data must outlive it.  Errors: MUKCA_MEMORY. */
mukca_status mukca_regression_create(mukca_regression *m, const mukca_chain *chain,
                                     const mukca_dataset *data,
                                     const mukca_recording_options *options, mukca_error *error);
void mukca_regression_free(mukca_regression *m);

/* Linearise at the present unknowns. */
void mukca_regression_linearise(mukca_regression *m);

/* Normal equations of the present columns under one family of the noise. */
mukca_normal_equations *mukca_regression_collect(mukca_regression *m, int index);

/* Evidence of the present columns, priors and noise, as mukca_evidence_evaluate returns it;
 * m->evidence keeps the factor of the posterior precision. */
double mukca_regression_factor(mukca_regression *m);

/* Posterior mean m->evidence.mean under one model of the unknowns (-1: all causes), or the mean
 * over them; false: the normal equations are singular. */
bool mukca_regression_solve(mukca_regression *m, const mukca_normal_equations *normal, int model);
bool mukca_regression_average(mukca_regression *m, const mukca_normal_equations *normal);

/* Standard error of the sum of direction[t] x[column + t], t < terms, in the posterior of the last
 * evaluation. */
double mukca_regression_standard_error(mukca_regression *m, int column, const double *direction,
                                       int terms);

/* Noise sigma that maximises the evidence, near `guess` or else globally; *value (may be NULL)
 * receives the evidence. */
double mukca_noise_choose(mukca_evidence *evidence, const mukca_normal_equations *normal,
                          double guess, double *value);

/* Maximise the evidence at the present noise over the geometry's two scales together, then over
 * that of each cause whose scale is open.  m->evidence.posterior.prior receives the prior sigmas of
 * all columns. */
void mukca_scales_choose(mukca_regression *m, const mukca_normal_equations *normal);

/* Quantities chosen by a fit in addition to the unknowns. */
typedef enum {
    MUKCA_FIT_UNKNOWNS, /* none: noise, its family and prior scales stay */
    /* Noise, its family and the geometry's prior scales by evidence, in the first and third step;
     * without correlation of successive samples: for predictions by an incomplete model, whose own
     * errors are correlated. */
    MUKCA_FIT_INDEPENDENT,
    MUKCA_FIT_ALL /* the same among all families */
} mukca_fit_freedom;

/* Log posterior of the set of causes fitted last, up to a constant: evidence, and the priors of the
 * causes and of their sizes. */
double mukca_regression_score(mukca_regression *m);

/* Fit by so many steps with Student's noise of independent samples, whose weight[n_rows] are those
 * of the unknowns from then on: noise, its share of the joint angles, weights and prior scales in
 * each.  m->evidence keeps mean and factor of the posterior. */
void mukca_regression_fit_tails(mukca_regression *m, double *weight, int steps);

/* Choose the share of the joint angles' noise, from the present one towards that of the residuals,
 * while the evidence increases.  The model must be linearised. */
void mukca_regression_choose_share(mukca_regression *m);

/* Student's or Gaussian noise, whichever is more probable at the present linearisation, where
 * samples are independent: m->unknowns.tails, NULL or weight[n_rows].  Returns the log posterior as
 * mukca_regression_score does. */
double mukca_regression_choose_tails(mukca_regression *m, double *weight);

/* Freeze: linearise at the present unknowns, for a search.  Return: to that linearisation with its
 * causes or with none. */
void mukca_regression_freeze(mukca_regression *m);
void mukca_regression_return(mukca_regression *m);

/* One Gauss-Newton step from the present linearisation, followed by a linearisation. */
void mukca_regression_step(mukca_regression *m, mukca_fit_freedom freedom);

/* Fit geometry and causes in at most `iterations` Gauss-Newton steps.  The final linearisation is
 * at the unknowns, or within 0.1 um of them. */
void mukca_regression_fit(mukca_regression *m, int iterations, mukca_fit_freedom freedom);

#endif
