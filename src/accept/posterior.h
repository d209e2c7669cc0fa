/* An arm's geometry and effects: their posterior given samples, for acceptance and for the
 * advice while recording.
 *
 * It is the regression of the diagnosis with Student's noise, one sample for each posture, and
 * priors of noise and geometry that few samples leave as they are. */
#ifndef MUKCA_ACCEPT_POSTERIOR_H
#define MUKCA_ACCEPT_POSTERIOR_H

#include "arm/tip_change.h"
#include "diagnose/regression.h"

typedef struct {
    const mukca_tip_change_task *task;
    mukca_chain chain; /* without the frame of the measurement before it */
    mukca_dataset data;
    mukca_regression m;    /* at the posterior mean, with the factor of its precision */
    double *weight;        /* [n_rows] of Student's noise */
    double (*residual)[3]; /* [n_rows] of the samples, m */
    int postures;          /* different ones */
    mukca_pool pool;
} mukca_arm_posterior;

/* Fit from the nominal arm, with the effects of the task's table (NULL: none), whose sizes are
 * nearly free: the evidence named them.  The frames of poses are unknown, for each log and target.
 * Recordings of more than 5000 rows are thinned.  Free it also after an error.  Errors:
 * MUKCA_MEMORY. */
mukca_status mukca_arm_posterior_fit(mukca_arm_posterior *p, const mukca_tip_change_task *task,
                                     mukca_error *error);
void mukca_arm_posterior_free(mukca_arm_posterior *p);

/* Add n effects of at most three times these coefficients, and fit again; *evidence: their log
 * Bayes factor. */
mukca_status mukca_arm_posterior_extend(double *evidence, mukca_arm_posterior *p,
                                        const mukca_effect *effects, int n, mukca_error *error);

/* Columns of base (six) and tool. */
enum { MUKCA_RIGID = 9 };

/* Rows X[3 n][ld] of the tip in postures q[n][n_joints]: columns of base and tool, those of the
 * unknowns, and minus the tip, m.  False: no memory. */
bool mukca_arm_posterior_probe(double *X, int ld, mukca_arm_posterior *p, const double *q, int n);

#endif
