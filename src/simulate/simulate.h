/* Simulated recordings: an arm whose true geometry, masses and effects are known, recording
 * faults and noise.
 *
 * The recorded angles are the encoders'; the true arm, displaced by its effects at those angles,
 * has its ball in the socket up to the noise.  The same seed gives the same rows everywhere; what
 * is drawn for one purpose (placements, postures, noise ...) does not depend on the other options.
 */
#ifndef MUKCA_SIMULATE_SIMULATE_H
#define MUKCA_SIMULATE_SIMULATE_H

#include <stdbool.h>
#include <stdint.h>

#include "math/random.h"
#include "mukca/dataset.h"

/* Purposes of random numbers. */
typedef enum {
    MUKCA_DRAW_GEOMETRY,
    MUKCA_DRAW_MASSES,
    MUKCA_DRAW_EFFECTS,
    MUKCA_DRAW_PLACES,
    MUKCA_DRAW_POSTURES,
    MUKCA_DRAW_NOISE,
    MUKCA_DRAW_EFFORT,
    MUKCA_DRAW_ROTATION,
    MUKCA_DRAW_TIME
} mukca_draw;

void mukca_simulate_seed(mukca_random *random, uint64_t seed, mukca_draw purpose);

/* An arm as it really is. */
typedef struct {
    mukca_chain chain;       /* with the true masses; its origins stay the nominal ones */
    mukca_geometry geometry; /* the true origins */
    int n_effects;
    mukca_effect effects[MUKCA_MAX_EFFECTS];
} mukca_true_arm;

/* What is recorded of a tool in one place of the workspace: two sockets on the x axis of `pose`,
 * symmetric about its origin. */
typedef struct {
    char name[MUKCA_NAME_SIZE];
    bool placed; /* false: to be found (mukca_simulate_places) */
    mukca_frame pose;
} mukca_place;

typedef enum {
    MUKCA_SIMULATED_STEP,         /* from `row` on the socket stands off by `shift` */
    MUKCA_SIMULATED_CREEP,        /* from `row` on it creeps there until the last row */
    MUKCA_SIMULATED_WRONG_SOCKET, /* the ball sat in the other socket */
    MUKCA_SIMULATED_OUTLIER,      /* the ball was not seated: off by `shift` */
    MUKCA_SIMULATED_DUPLICATE     /* the row before was recorded again */
} mukca_simulated_fault_kind;

typedef struct {
    mukca_simulated_fault_kind kind;
    int placement, socket; /* index of the place; 0 or 1 */
    int row;               /* 0-based, within the socket */
    double shift[3];       /* m, base frame */
} mukca_simulated_fault;

/* How rows are recorded.  Zeroed: 30 rows per socket, 50 mm, no noise, 5 s between rows. */
typedef struct {
    int rows; /* per socket */
    double distance;
    double noise;       /* sigma per axis at the ball, m */
    double rotation;    /* sigma per axis of measured orientations, rad (pose logs) */
    double correlation; /* of the noise of a row with that of the row before */
    double interval;    /* mean seconds between rows */
    bool sweep;         /* postures follow each other smoothly; else each is random */
    bool effort, command;
    double effort_noise; /* sigma, N m */
    double payload;      /* kg at the tip, recorded where it is not 0 */
    bool position_only;  /* pose logs: no orientations */
    uint64_t seed;
    bool (*interrupted)(void); /* asked at each row; may be NULL */
} mukca_simulate_options;

/* Give every free parameter of theta[6 * n_elements] (in: nominal) a normal error of `shift` m or
 * `turn` rad; listed[] (may be NULL) is set to 1 for those. */
void mukca_simulate_perturb(double *theta, unsigned char *listed, const mukca_chain *chain,
                            double shift, double turn, uint64_t seed);

/* The arm with those origins, each mass off by a normal error of `mass_error` (relative); no
 * effects yet. */
void mukca_simulate_arm(mukca_true_arm *arm, const mukca_chain *chain, const double *theta,
                        double mass_error, uint64_t seed);

/* Find poses for the places that have none: both sockets in reach in many postures, above the base
 * where the arm can, far from the other places.  Only the nominal arm counts.
 * Errors: MUKCA_INPUT (the arm reaches nothing). */
mukca_status mukca_simulate_places(mukca_place *places, int n_places, const mukca_chain *chain,
                                   double distance, uint64_t seed, mukca_error *error);

/* What is recorded with sockets; `faults` may be NULL. */
typedef struct {
    const mukca_true_arm *arm;
    const mukca_place *places;
    int n_places;
    const mukca_simulated_fault *faults;
    int n_faults;
    const mukca_simulate_options *options;
} mukca_simulated_session;

/* Record the arm with its ball in the sockets of all places in order.  Free with
 * mukca_dataset_free.  Errors: MUKCA_INPUT (a place out of reach), MUKCA_MEMORY,
 * MUKCA_INTERRUPTED. */
mukca_status mukca_simulate_sockets(mukca_dataset *data, const mukca_simulated_session *session,
                                    mukca_error *error);

/* Record a pose log of n_rows rows: at the angles q[n_rows][n_joints], or (NULL) at postures of its
 * own.  Errors: MUKCA_MEMORY, MUKCA_INTERRUPTED. */
mukca_status mukca_simulate_poses(mukca_dataset *data, const mukca_true_arm *arm, const double *q,
                                  int n_rows, const mukca_simulate_options *options,
                                  mukca_error *error);

/* Where a socket of a place is in row `row` (0-based) of it, faults included; m, base frame. */
void mukca_simulate_seat(double position[3], const mukca_simulated_session *session, int place,
                         int socket, int row);

/* A random posture within the limits (without limits: +- pi, +- 0.5 m), q[n_joints]. */
void mukca_simulate_posture(double *q, const mukca_chain *chain, mukca_random *random);

#endif
