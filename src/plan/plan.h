/* The next poses to record: for accuracy (D-optimality) or to separate two causes (T-optimality).
 *
 * Unknown are the geometry (a Gaussian prior of a few mm and mrad about the model in use), the mean
 * of each socket, and the coefficients of the causes in question.  Each row that is recorded takes
 * its share off their covariance; poses are chosen one by one, each as the best of many candidates
 * that the arm can take with the ball in a socket, and then exchanged while that helps.
 */
#ifndef MUKCA_PLAN_PLAN_H
#define MUKCA_PLAN_PLAN_H

#include <stdint.h>

#include "mukca/dataset.h"
#include "mukca/effect.h"

/* Log Bayes factor from which a diagnosis names one of two causes however alike they are. */
#define MUKCA_PLAN_NAME 6.0

enum { MUKCA_PLAN_MAX_SOCKETS = 64, MUKCA_PLAN_MAX_EFFECTS = 4 };

/* A seat for the ball, in the base frame of the model in use. */
typedef struct {
    char placement[MUKCA_NAME_SIZE], label[MUKCA_NAME_SIZE];
    int place;        /* number of the placement, 0.. */
    double centre[3]; /* m */
} mukca_plan_socket;

/* Zeroed means the defaults. */
typedef struct {
    int rows;       /* to propose, all sockets together; 0: 20 */
    int candidates; /* poses tried per socket; 0: 150 */
    uint64_t seed;
    double noise;      /* of one coordinate of a row, m; 0: 1e-4 */
    double tilt;       /* of the tool from straight down, at most, rad; 0: pi / 3, or what the data
                          show; > pi: any */
    double clearance;  /* of the joints above the base's plane (or a lower socket), m; 0: 0.05, or
                          what the data show; NaN: any */
    double separation; /* least difference to other poses in some joint, rad; 0: 0.2 */
    double margin;     /* kept from the joint limits, rad or m; 0: 0.02 */
    double payload;    /* kg at the tip beyond the model, of the proposed postures */
    const mukca_effect *effects; /* causes in question; NULL: plan for accuracy */
    int n_effects;               /* at least 2 unless 0 */
    bool poses_only;             /* for causes: expected errors are not wanted (0) */
    bool (*stop)(void *context); /* asked now and then; may be NULL */
    void (*progress)(void *context, double done); /* share, 0 .. 1; may be NULL */
    void *context;
} mukca_plan_options;

typedef struct {
    int socket;
    double q[MUKCA_MAX_JOINTS];
} mukca_plan_row;

typedef struct {
    int n_rows;
    mukca_plan_row *rows;                   /* owned; in the order to record them */
    int n_recorded;                         /* rows that were there before */
    double expected_before, expected_after; /* rms error of the ball in a socket elsewhere that the
                                               geometry's uncertainty leaves, m */
    double evidence_before, evidence_after; /* expected log Bayes factor of the weaker cause when it
                                               is the true one; NaN for accuracy */
    int rows_to_name;   /* about how many rows like these would bring the evidence to
                           MUKCA_PLAN_NAME; 0: more than 1000, or not asked for */
    int tried, reached; /* candidate poses */
} mukca_plan;

/* Sockets of the rows of a dataset, centres predicted by `geometry`.  Returns their number. */
int mukca_plan_sockets(mukca_plan_socket *sockets, int room, const mukca_geometry *geometry,
                       const mukca_dataset *data);

/* What to plan for. */
typedef struct {
    const mukca_chain *chain;
    const double *theta;              /* [6 * n_elements] of the model in use; NULL: nominal */
    const mukca_dataset *data;        /* recorded so far; NULL: nothing */
    const mukca_plan_socket *sockets; /* [n_sockets]; not used for places */
    int n_sockets;
    double distance; /* between the sockets of a place, m */
} mukca_plan_task;

/* Propose rows at the sockets.  Free with mukca_plan_free.  Errors: MUKCA_USAGE, MUKCA_INPUT (no
 * posture reaches the sockets), MUKCA_MEMORY, MUKCA_INTERRUPTED. */
mukca_status mukca_plan_run(mukca_plan *plan, const mukca_plan_task *task,
                            const mukca_plan_options *options, mukca_error *error);
void mukca_plan_free(mukca_plan *plan);

/* Where postures alone do not bring the evidence to MUKCA_PLAN_NAME: the smallest usual mass at the
 * tip with which as many postures do, up to a third of the arm's own, which few arms carry.
 * *payload gets it and *plan the postures with it; without such a mass *payload is 0 and *plan
 * stays.  Errors: as mukca_plan_run. */
mukca_status mukca_plan_payload(double *payload, mukca_plan *plan, const mukca_plan_task *task,
                                const mukca_plan_options *options, mukca_error *error);

/* A place for the tool and what recording there would bring. */
typedef struct {
    double centre[3],
        yaw; /* middle of the two sockets, m; direction from the first to the other, rad */
    double expected, evidence; /* as expected_after and evidence_after, options->rows rows there */
} mukca_plan_place;

/* The `n_places` places of a grid around the arm that are worth most, for accuracy or (with
 * effects) for evidence; the later ones given the earlier.  *n_found gets their number.
 * Errors: as mukca_plan_run. */
mukca_status mukca_plan_places(mukca_plan_place *places, int *n_found, int n_places,
                               const mukca_plan_task *task, const mukca_plan_options *options,
                               mukca_error *error);

#endif
