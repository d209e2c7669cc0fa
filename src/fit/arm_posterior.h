/* An arm's geometry and effects: derivatives of its tip, priors, and posterior given samples, for
 * planning, acceptance and the advice while recording.
 *
 * The linearisation is of one posture at a time; the calibration differentiates all samples at once
 * (sweep.h), the diagnosis has its own columns (diagnose/linearisation.c), and chooses its priors
 * by the evidence (diagnose/evidence.c). */
#ifndef MUKCA_FIT_ARM_POSTERIOR_H
#define MUKCA_FIT_ARM_POSTERIOR_H

#include "arm/tip_change.h"
#include "fit/parameters.h"
#include "infer/posterior.h"

/* ---- derivatives of the tip (arm_point.c) ---- */

enum { MUKCA_MOST_UNKNOWNS = MUKCA_MAX_FREE + MUKCA_MAX_EFFECTS * MUKCA_MAX_TERMS };

/* A point in the space of the unknowns: parameters, then coefficients of the effects. */
typedef struct {
    const mukca_chain *chain;
    mukca_parameters parameters;
    int n, n_effects; /* unknowns; effects */
    double theta[MUKCA_MAX_FREE];
    mukca_geometry geometry; /* of theta */
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    double sigma[MUKCA_MOST_UNKNOWNS]; /* prior; of parameters mukca_prior_expected */
} mukca_arm_point;

/* The default parameters at theta[6 * n_elements] (NULL: nominal), without effects; `chain` must
 * outlive the point. */
void mukca_arm_point_init(mukca_arm_point *at, const mukca_chain *chain, const double *theta);

/* Move to theta[6 * n_elements], at->theta itself is allowed. */
void mukca_arm_point_move(mukca_arm_point *at, const double *theta);

/* Own unknowns of a group of observations (infer/posterior.h) in its columns 0, 3 and 6: the centre
 * of a socket, or base (shift and rotation) and target of a pose log. */
enum { MUKCA_OWN_SHIFT = 1, MUKCA_OWN_TURN = 2, MUKCA_OWN_TARGET = 4 };

/* Add to x[3][MUKCA_OWN + n + 1] the derivatives of the tip by these own unknowns and by the
 * unknowns, per sigma, at theta (that of `geometry`), and minus its position, m. */
void mukca_arm_point_rows(double *x, const mukca_arm_point *at, const mukca_geometry *geometry,
                          const double *theta, const mukca_joint_state *state, int own);

/* ---- posterior: geometry and effects, with these priors in a scale chosen by the data,
 * heavy-tailed noise, and the readings of one posture as one sample (arm_posterior.c) ---- */

typedef struct {
    const mukca_tip_change_task *task;
    mukca_chain chain; /* without the frame of the measurement before it */
    const double *to;  /* theta of the table, for this chain */
    mukca_dataset data;
    mukca_arm_point at; /* an effect's sigma is nearly flat: the evidence named the effect */
    double nominal[MUKCA_MAX_THETA];
    bool poses; /* whether there are any, which have these own unknowns: */
    int own;
    mukca_frame tracker; /* of the group in work */
    int n_list, postures;
    mukca_observation *list; /* [n_list] means of the readings of one posture in one group: a
                                socket, or a target of a pose log; and their numbers: */
    int *readings;
    bool *outlier;         /* [n_list] beyond the noise */
    int *of_row;           /* [n_rows] observation */
    mukca_grouped groups;  /* at `at`; its prior sigmas are factors of `sigma` */
    double *mean;          /* [n] of the prior, from the present unknowns */
    double *inverse;       /* [n][n] scratch */
    double scale;          /* of the priors of the arm's joints */
    int extended;          /* first unknown of mukca_arm_posterior_extend, and */
    double extended_scale; /* the scale of their priors */
    int gross;             /* observations beyond any arm and noise */
    double worst_m;        /* largest error of an observation */
    mukca_pool pool;
} mukca_arm_posterior;

/* Prior of the measurement noise, m: the repeatability of a printed socket is 0.1 to 0.2 mm. */
#define MUKCA_PRIOR_NOISE 1.5e-4

/* Gauss-Newton from the nominal arm: p->groups at p->at, with the effects of the task's table
 * (NULL: none).  Recordings of more than 5000 rows are thinned.  Free it also after an error.
 * Errors: MUKCA_MEMORY. */
mukca_status mukca_arm_posterior_fit(mukca_arm_posterior *p, const mukca_tip_change_task *task,
                                     mukca_error *error);
/* Add n effects, their sigmas three times the coefficients given, by one more step; *gain: the
 * reduction of the residuals beyond that of pure noise, in standard deviations of the latter. */
mukca_status mukca_arm_posterior_extend(double *gain, mukca_arm_posterior *p,
                                        const mukca_effect *effects, int n, mukca_error *error);

void mukca_arm_posterior_free(mukca_arm_posterior *p);

/* Set p->groups with the present weights, noise and scale. */
void mukca_arm_posterior_solve(mukca_arm_posterior *p);

/* After the fit: whether the residuals are those of a tip that turns about the axis of a joint
 * whose angles do not change. */
bool mukca_arm_posterior_turns(const mukca_arm_posterior *p, int joint);

/* After the fit: random postures q[n][n_joints] within the limits of `range`, and their rows
 * X[3 n][ld] as of mukca_arm_point_rows with the own unknowns of poses.  Seeds `random` first. */
void mukca_arm_posterior_probe(double *X, int ld, double *q, const mukca_arm_posterior *p,
                               const mukca_chain *range, int n, mukca_random *random);

#endif
