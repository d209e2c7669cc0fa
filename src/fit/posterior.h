/* Gaussian prior of the geometry and its posterior given samples.
 *
 * Information form: L L' = J'J / noise^2 + diag(1 / sigma^2), for planning and, of an arm, for
 * acceptance and the advice while recording.  The diagnosis chooses its priors by the evidence
 * (diagnose/evidence.c).
 *
 * The linearisation is of one posture at a time; the calibration differentiates all samples at once
 * (sweep.h), the diagnosis has its own columns (diagnose/linearisation.c).
 */
#ifndef MUKCA_FIT_POSTERIOR_H
#define MUKCA_FIT_POSTERIOR_H

#include "arm/tip_change.h"
#include "base/pool.h"
#include "fit/parameters.h"

/* An arm at which the tip is differentiated by the default parameters. */
typedef struct {
    const mukca_chain *chain;
    mukca_parameters parameters;
    double theta[MUKCA_MAX_FREE]; /* [6 * n_elements] */
    mukca_geometry geometry;      /* of theta */
} mukca_arm_point;

/* At theta[6 * n_elements] (NULL: nominal); `chain` must outlive it. */
void mukca_arm_point_init(mukca_arm_point *at, const mukca_chain *chain, const double *theta);

/* Move to theta[6 * n_elements], at->theta itself is allowed. */
void mukca_arm_point_move(mukca_arm_point *at, const double *theta);

/* Position of the tip, m (may be NULL), and its Jacobian J[3][ld] with respect to the n free
 * parameters (m/m, m/rad), in the first n columns. */
void mukca_arm_point_tip(double *J, int ld, double position[3], const mukca_arm_point *at,
                         const double *q);

/* Prior sigma[n] of the free parameters, mukca_prior_expected. */
void mukca_posterior_prior(double *sigma, const mukca_chain *chain,
                           const mukca_parameters *parameters);

/* L[n][n], the Cholesky factor of the information; gram[n][n] is J'J of the samples. */
void mukca_posterior_factor(double *L, const double *gram, const double *sigma, double noise,
                            int n);

/* ---- of an arm given samples: geometry and effects, with these priors in a scale chosen by the
 * data, heavy-tailed noise, and the readings of one posture as one sample (arm_posterior.c) ---- */

/* Columns of what no table contains: the centre of a socket, or base (rotation and shift) and
 * target of a pose log. */
enum { MUKCA_NUISANCE = 9 };

/* Mean of the readings of one posture in one group: a socket, or a target of a pose log. */
typedef struct {
    int group, rows, next; /* next: observation of the same posture, -1: none */
    double weight, *x;     /* [3][width]: nuisance, unknowns (per prior sigma), residual, m */
} mukca_arm_observation;

typedef struct {
    const mukca_tip_change_task *task;
    mukca_chain chain; /* without the frame of the measurement before it */
    const double *to;  /* theta of the table, for this chain */
    mukca_dataset data;
    mukca_parameters parameters;
    bool base, tool, poses;   /* unknown frames of measured poses; whether there are any */
    int n_geometry, n, width; /* unknowns: parameters, then coefficients of the table's effects */
    int n_groups, n_list, postures;
    double nominal[MUKCA_MAX_THETA], theta[MUKCA_MAX_THETA];
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    mukca_frame tracker;     /* of the group in work */
    double *sigma;           /* [n] prior standard deviations; those of the arm's joints * scale */
    double *mean, *step;     /* [n] prior and posterior mean, from the present unknowns */
    double *L, *inverse;     /* [n][n] Cholesky factor of the precision; its inverse */
    double *gram;            /* [width][width] of a group */
    double *reduced;         /* [n_groups][MUKCA_NUISANCE][width]: gives nuisance, socket means */
    double *group_weight;    /* [n_groups] */
    double *distance_weight; /* [n_distances] */
    mukca_arm_observation *list;
    int *of_row; /* [n_rows] observation */
    double noise, scale, misfit;
    int outliers, gross; /* observations beyond the noise; beyond any arm and noise */
    double worst_m;      /* largest error of an observation */
    mukca_pool pool;
} mukca_arm_posterior;

/* Prior of the measurement noise, m: the repeatability of a printed socket is 0.1 to 0.2 mm. */
#define MUKCA_PRIOR_NOISE 1.5e-4

/* Choose the unknowns at the nominal arm; recordings of more than 5000 rows are thinned.  Free it
 * also after an error.  Errors: MUKCA_MEMORY. */
mukca_status mukca_arm_posterior_create(mukca_arm_posterior *p, const mukca_tip_change_task *task,
                                        mukca_error *error);
void mukca_arm_posterior_free(mukca_arm_posterior *p);

/* Gauss-Newton from there: p->L at p->theta and p->effects.  Errors: MUKCA_MEMORY. */
mukca_status mukca_arm_posterior_fit(mukca_arm_posterior *p, mukca_error *error);

/* Set p->L and p->step with the present weights, noise and scale. */
void mukca_arm_posterior_solve(mukca_arm_posterior *p);

/* After the fit: whether the residuals are those of a tip that turns about the axis of a joint
 * whose angles do not change. */
bool mukca_arm_posterior_turns(const mukca_arm_posterior *p, int joint);

/* The coefficient of column `c` of the effects. */
double *mukca_arm_posterior_coefficient(mukca_arm_posterior *p, int c);

/* Add to x[3][width] the position of the tip at theta (that of `geometry`), in the last column, and
 * its derivatives; `poses`: with the nuisance of a pose log, else of a socket. */
void mukca_arm_posterior_add(double *x, mukca_arm_posterior *p, const mukca_geometry *geometry,
                             const double *theta, const mukca_joint_state *state, bool poses);

#endif
