/* The next postures to record: for accuracy (D-optimality) or to distinguish two causes
 * (T-optimality).
 *
 * The unknowns are the geometry (Gaussian prior of a few mm and mrad about the model in use), the
 * mean of each socket, and the coefficients of the causes in question.  Each sample reduces their
 * covariance.  Postures are chosen one by one, each the best of many reachable candidates with the
 * ball in a socket, and then exchanged as long as that improves the plan. */
#ifndef MUKCA_PLAN_PLAN_H
#define MUKCA_PLAN_PLAN_H

#include <stdint.h>

#include "model/dataset.h"
#include "mukca/effect.h"

/* Log Bayes factor above which a diagnosis names one of two causes even if they are strongly
 * correlated. */
#define MUKCA_PLAN_NAME 6.0

enum { MUKCA_PLAN_MAX_SOCKETS = 64, MUKCA_PLAN_MAX_EFFECTS = 2 };

/* A socket, in the base frame of the model in use. */
typedef struct {
    char placement[MUKCA_NAME_SIZE], label[MUKCA_NAME_SIZE];
    int place;        /* index of the placement, from 0 */
    double centre[3]; /* m */
} mukca_plan_socket;

/* Zeroed options mean defaults. */
typedef struct {
    int rows; /* samples to propose, all sockets together; 0: 20 */
    uint64_t seed;
    double noise;          /* standard deviation of one coordinate of a sample, m; 0: 1e-4 */
    double distance_sigma; /* of the distance between two sockets of a placement, m; 0:
                              MUKCA_DISTANCE_SIGMA */
    double tilt; /* largest tilt of the tool from straight down, rad; 0: pi / 3, or the largest in
                    the data; > pi: any */
    double payload; /* of the proposed postures: kg at the tip that the model does not include */
    const mukca_effect *effects; /* causes to distinguish; NULL: plan for accuracy */
    int n_effects;               /* 2, or 0: plan for accuracy */
    double measured; /* log Bayes factor between two causes in the data, by a diagnosis; 0: none */
    bool poses_only; /* for causes: omit the expected errors (they are 0) */
    bool (*stop)(void *context);                  /* polled during the search; may be NULL */
    void (*progress)(void *context, double done); /* fraction done, 0 .. 1; may be NULL */
    void *context;
} mukca_plan_options;

typedef struct {
    int socket;
    double q[MUKCA_MAX_JOINTS];
} mukca_plan_row;

typedef struct {
    int n_rows;
    mukca_plan_row *rows;                   /* owned; in the order to record them */
    int n_recorded;                         /* samples of the dataset in the plan's sockets */
    double expected_before, expected_after; /* expected mean error of the ball in other sockets due
                                               to the uncertainty of the geometry, m */
    double evidence_before, evidence_after; /* expected log Bayes factor of the weaker cause, if it
                                               is the true one (`measured`: of the data, and with
                                               the expected gain); NaN for accuracy */
    int rows_to_name; /* estimated number of such samples until the evidence reaches
                         MUKCA_PLAN_NAME; 0: more than 1000, or planned for accuracy */
} mukca_plan;

/* Sockets of a dataset with samples, at most `room`, and the centres that `geometry` predicts.
 * Returns their number; *left_out: that of the others. */
int mukca_plan_sockets(mukca_plan_socket *sockets, int room, int *left_out,
                       const mukca_geometry *geometry, const mukca_dataset *data);

/* Input of a plan. */
typedef struct {
    const mukca_chain *chain;
    const double *theta;              /* [6 * n_elements] of the model in use; NULL: nominal */
    const mukca_dataset *data;        /* samples recorded so far; NULL: none */
    const mukca_plan_socket *sockets; /* [n_sockets] */
    int n_sockets;
} mukca_plan_task;

/* Propose samples at the sockets.  Free with mukca_plan_free.  Errors: MUKCA_INPUT (no posture
 * reaches the sockets), MUKCA_MEMORY, MUKCA_INTERRUPTED. */
mukca_status mukca_plan_run(mukca_plan *plan, const mukca_plan_task *task,
                            const mukca_plan_options *options, mukca_error *error);
void mukca_plan_free(mukca_plan *plan);

/* The smallest common payload with which the evidence of as many samples reaches MUKCA_PLAN_NAME,
 * for plans whose postures alone do not suffice.  Payloads up to a third of the arm's own mass are
 * tried; few arms carry more.  *payload is its mass (kg), *plan the plan with it.  Without such a
 * payload *payload is 0 and *plan is unchanged.  Errors: as mukca_plan_run. */
mukca_status mukca_plan_payload(double *payload, mukca_plan *plan, const mukca_plan_task *task,
                                const mukca_plan_options *options, mukca_error *error);

#endif
