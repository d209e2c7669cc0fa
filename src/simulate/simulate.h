/* Simulated recordings of an arm with known true geometry, masses, effects, recording faults and
 * noise.
 *
 * The recorded angles are those of the encoders.  The ball of the true arm, displaced by its
 * effects at those angles, is in the socket within the noise.  The same seed gives the same
 * recording on every machine; random numbers of one purpose (placements, postures, noise ...) do
 * not depend on the options of another. */
#ifndef MUKCA_SIMULATE_SIMULATE_H
#define MUKCA_SIMULATE_SIMULATE_H

#include <stdbool.h>
#include <stdint.h>

#include "math/random.h"
#include "model/dataset.h"
#include "mukca/corrected.h"
#include "mukca/row_state.h"

/* Purposes of random numbers. */
typedef enum {
    MUKCA_DRAW_GEOMETRY,
    MUKCA_DRAW_EFFECTS = 2, /* recordings keep their bytes */
    MUKCA_DRAW_PLACES,
    MUKCA_DRAW_POSTURES,
    MUKCA_DRAW_NOISE,
    MUKCA_DRAW_ROTATION = 7,
    MUKCA_DRAW_TIME
} mukca_draw;

void mukca_simulate_seed(mukca_random *random, uint64_t seed, mukca_draw purpose);

/* A placement: two sockets on the x axis of `pose`, symmetric about its origin. */
typedef struct {
    char name[MUKCA_NAME_SIZE];
    bool placed; /* false: to be determined (mukca_simulate_places) */
    mukca_frame pose;
} mukca_place;

typedef enum {
    MUKCA_SIMULATED_STEP,         /* the socket is displaced by `shift` from sample `row` on */
    MUKCA_SIMULATED_CREEP,        /* the displacement grows from sample `row` to the last */
    MUKCA_SIMULATED_WRONG_SOCKET, /* the ball was in the other socket */
    MUKCA_SIMULATED_OUTLIER,      /* the ball was not seated: displaced by `shift` */
    MUKCA_SIMULATED_DUPLICATE     /* the preceding sample was recorded again */
} mukca_simulated_fault_kind;

typedef struct {
    mukca_simulated_fault_kind kind;
    int placement, socket; /* index of the placement; 0 or 1 */
    int row;               /* index of the sample in the socket, from 0 */
    double shift[3];       /* m, base frame */
} mukca_simulated_fault;

/* Options of a recording. */
typedef struct {
    int rows;        /* samples per socket */
    double distance; /* between the sockets of a pair, m */
    double noise;    /* sigma per axis at the ball, m */
    double rotation; /* sigma per axis of measured orientations, rad (pose logs) */
    bool effort, command;
    double payload;     /* at the tip, kg; recorded unless 0 */
    bool position_only; /* pose logs: no orientations */
    uint64_t seed;
    bool (*interrupted)(void); /* polled at each sample; may be NULL */
} mukca_simulate_options;

/* Add normal errors of `shift` m or `turn` rad to every free parameter of theta[6 * n_elements]
 * (in: nominal) and set listed[] (may be NULL) to 1 for those. */
void mukca_simulate_perturb(double *theta, unsigned char *listed, const mukca_chain *chain,
                            double shift, double turn, uint64_t seed);

/* Initialise a simulated arm: `chain` has the true masses and the nominal origins, theta the true
 * ones; without effects. */
void mukca_simulate_arm(mukca_corrected *arm, const mukca_chain *chain, const double *theta);

/* Find poses for the undetermined placements: both sockets reachable in many postures of the
 * nominal arm, above the base if possible, far from the other placements.  Errors: MUKCA_INPUT
 * (nothing is reachable). */
mukca_status mukca_simulate_places(mukca_place *places, int n_places, const mukca_chain *chain,
                                   double distance, uint64_t seed, mukca_error *error);

/* Input of a recording with sockets; `faults` may be NULL. */
typedef struct {
    const mukca_corrected *arm;
    const mukca_place *places;
    int n_places;
    const mukca_simulated_fault *faults;
    int n_faults;
    const mukca_simulate_options *options;
} mukca_simulated_session;

/* Record the arm with its ball in the sockets of all placements in order.  Free with
 * mukca_dataset_free.  Errors: MUKCA_INPUT (a socket is out of reach), MUKCA_MEMORY,
 * MUKCA_INTERRUPTED. */
mukca_status mukca_simulate_sockets(mukca_dataset *data, const mukca_simulated_session *session,
                                    mukca_error *error);

/* Record a pose log of n_rows samples at the angles q[n_rows][n_joints] or (NULL) at simulated
 * postures.  Errors: MUKCA_MEMORY, MUKCA_INTERRUPTED. */
mukca_status mukca_simulate_poses(mukca_dataset *data, const mukca_corrected *arm, const double *q,
                                  int n_rows, const mukca_simulate_options *options,
                                  mukca_error *error);

/* Position of a socket during sample `row` (from 0), including faults; m, base frame. */
void mukca_simulate_seat(double position[3], const mukca_simulated_session *session, int place,
                         int socket, int row);

/* Draw a random posture q[n_joints] within the limits (without limits: +- pi, +- 0.5 m). */
void mukca_simulate_posture(double *q, const mukca_chain *chain, mukca_random *random);

#endif
