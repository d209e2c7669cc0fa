/* Posterior covariance of geometry, causes and socket means, and the information gain of one more
 * sample. */
#ifndef MUKCA_PLAN_STATE_H
#define MUKCA_PLAN_STATE_H

#include "base/pool.h"
#include "fit/posterior.h"
#include "plan/plan.h"

/* A pose in a socket with its design H[3][n_known]: derivatives of the ball's position by geometry
 * and causes, m per m, rad or unit of the cause. */
typedef struct {
    int socket;
    bool used;
    double q[MUKCA_MAX_JOINTS];
    double *H;
    double bound; /* upper bound of the gain, from an earlier step */
} mukca_plan_pose;

typedef struct {
    mukca_linearisation at;
    const mukca_plan_options *options;
    double noise;   /* m */
    double payload; /* of the next samples to be designed, kg */
    int n_geometry, n_effects, n_terms, n_sockets;
    mukca_effect effect[MUKCA_PLAN_MAX_EFFECTS];
    int first_term[MUKCA_PLAN_MAX_EFFECTS + 1]; /* of each effect in the columns of the causes */
    int n_known;                                /* n_geometry + n_terms: columns of a pose's H */
    int n;                                      /* n_known + 3 n_sockets */
    double *C;                                  /* [n][n] covariance of all unknowns */
    double *P;         /* [n_geometry][n_geometry] Cholesky factor of the geometry's block of C */
    double *elsewhere; /* [n_elsewhere][3][n_geometry] derivatives of the ball's position at the
                          evaluation postures, less the mean of their point */
    int n_elsewhere;
    double *W; /* [n_geometry][n_geometry] sum of J'J over them, each divided by its rms error */
    bool accuracy; /* gains are computed with W instead of the determinant */
    double *G;     /* [n][3] scratch */
    mukca_pool pool;
} mukca_plan_state;

/* Initialise with the prior, no samples.  Errors: MUKCA_MEMORY, MUKCA_USAGE. */
mukca_status mukca_plan_state_create(mukca_plan_state *s, const mukca_plan_task *task,
                                     int n_sockets, const mukca_plan_options *options,
                                     mukca_error *error);
void mukca_plan_state_free(mukca_plan_state *s);

/* Design H of posture q; `before` is the preceding posture, may be NULL. */
void mukca_plan_design(double *H, mukca_plan_state *s, const double *q, int place,
                       const double *before);

/* Add a sample at `socket` (sign 1) or remove it (sign -1).  Call mukca_plan_state_refresh before
 * the next gain. */
void mukca_plan_state_row(mukca_plan_state *s, const double *H, int socket, int sign);

/* Add the known distance between sockets a and b, whose centres are given, as an observation. */
void mukca_plan_state_distance(mukca_plan_state *s, int a, int b, const double *centre_a,
                               const double *centre_b);

/* Recompute P. */
void mukca_plan_state_refresh(mukca_plan_state *s);

/* Information gain of a sample: the decrease of the log determinant of the covariance of the
 * geometry, or of each cause; after mukca_plan_state_weigh, of the weighted error at the evaluation
 * points. */
double mukca_plan_gain(mukca_plan_state *s, const double *H, int socket);

/* Expected mean error of the ball at the evaluation points, m. */
double mukca_plan_expected(const mukca_plan_state *s);

/* Select that mean error as the criterion of gains.  Each posture is weighted by the inverse of its
 * present error: the sum of squares then decreases as the sum of errors does. */
void mukca_plan_state_weigh(mukca_plan_state *s);

/* Strength of the weakest cause: the square of its size over its standard error, which grows with
 * the number of samples; NaN without causes. */
double mukca_plan_strength(const mukca_plan_state *s);

/* Expected log Bayes factor of a cause of this strength. */
double mukca_plan_evidence(double strength);

#endif
