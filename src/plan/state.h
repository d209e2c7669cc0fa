/* What is known about geometry, causes and sockets' means, and what one more row would add. */
#ifndef MUKCA_PLAN_STATE_H
#define MUKCA_PLAN_STATE_H

#include "base/pool.h"
#include "fit/posterior.h"
#include "plan/plan.h"

/* One pose of the arm in a socket with its design: H[3][n_known], the ball's position by geometry
 * and causes, m per m, rad or unit of the cause. */
typedef struct {
    int socket;
    bool used;
    double q[MUKCA_MAX_JOINTS];
    double *H;
    double bound; /* of the gain, from an earlier step */
} mukca_plan_pose;

typedef struct {
    mukca_linearisation at;
    const mukca_plan_options *options;
    double noise;   /* m */
    double payload; /* of the samples that are designed next, kg */
    int n_geometry, n_effects, n_terms, n_sockets;
    mukca_effect effect[MUKCA_PLAN_MAX_EFFECTS];
    int first_term[MUKCA_PLAN_MAX_EFFECTS + 1]; /* of each effect among the causes' columns */
    int n_known;                                /* n_geometry + n_terms: columns of a pose's H */
    int n;                                      /* n_known + 3 n_sockets */
    double *C;                                  /* [n][n] covariance of all unknowns */
    double *P;         /* [n_geometry][n_geometry] inverse of its part of the geometry */
    double *elsewhere; /* [n_elsewhere][3][n_geometry] moves of the ball in other sockets per
                          unknown, less their socket's mean */
    int n_elsewhere;
    double
        *W; /* [n_geometry][n_geometry] sum of their squares, each weighed by one over its error */
    bool accuracy; /* gains are of W, not of the determinant */
    double *G;     /* [n][3] scratch */
    mukca_pool pool;
} mukca_plan_state;

/* An arm of which only the prior is known.  Errors: MUKCA_MEMORY, MUKCA_USAGE. */
mukca_status mukca_plan_state_create(mukca_plan_state *s, const mukca_plan_task *task,
                                     int n_sockets, const mukca_plan_options *options,
                                     mukca_error *error);
void mukca_plan_state_free(mukca_plan_state *s);

/* H of a pose; `before` (may be NULL) is the pose that the arm comes from. */
void mukca_plan_design(double *H, mukca_plan_state *s, const double *q, int place,
                       const double *before);

/* Add a row at `socket` (sign 1), or remove it (sign -1).  Refresh before gains. */
void mukca_plan_state_row(mukca_plan_state *s, const double *H, int socket, int sign);

/* Take that sockets a and b with these centres are a known distance apart. */
void mukca_plan_state_distance(mukca_plan_state *s, int a, int b, const double *centre_a,
                               const double *centre_b);

/* Renew P. */
void mukca_plan_state_refresh(mukca_plan_state *s);

/* What a row is worth: the fall of the log determinant of the covariance in question (geometry, or
 * each cause), or after mukca_plan_state_weigh of the weighed error elsewhere. */
double mukca_plan_gain(mukca_plan_state *s, const double *H, int socket);

/* Mean error of the ball elsewhere, m. */
double mukca_plan_expected(const mukca_plan_state *s);

/* From now on gains are of that mean error: weigh each place by the inverse of its present error,
 * so that the sum of the squares falls as the sum of the errors does. */
void mukca_plan_state_weigh(mukca_plan_state *s);

/* The square of the weakest cause's size over its standard error, which grows as rows are added;
 * NaN without causes. */
double mukca_plan_strength(const mukca_plan_state *s);

/* The expected log Bayes factor that goes with it. */
double mukca_plan_evidence(double strength);

#endif
