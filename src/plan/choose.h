/* Information of samples on geometry and causes, candidates, and the choice among them. */
#ifndef MUKCA_PLAN_CHOOSE_H
#define MUKCA_PLAN_CHOOSE_H

#include "base/pool.h"
#include "fit/parameters.h"
#include "infer/posterior.h"
#include "math/random.h"
#include "model/dataset_subset.h"
#include "plan/plan.h"

/* ---- random postures with the ball in a socket, within the limits of arm and tool (poses.c) ----
 */

/* The arm and the rules for its postures; clearance: least height of the joints above the base's
 * plane (or a lower socket), m. */
typedef struct {
    const mukca_chain *chain;
    const mukca_geometry *geometry;
    double tilt, clearance;
} mukca_plan_rules;

/* The rules of `options`; a default is widened to include all recorded samples.  `data` may be
 * NULL; chain and geometry must outlive the rules. */
void mukca_plan_rules_set(mukca_plan_rules *rules, const mukca_chain *chain,
                          const mukca_geometry *geometry, const mukca_plan_options *options,
                          const mukca_dataset *data);

/* Draw a posture q[n_joints] with the tip at `centre` (m) from a random start; false: this draw
 * failed. */
bool mukca_plan_draw_pose(double *q, const double centre[3], const mukca_plan_rules *rules,
                          mukca_random *random);

/* Draw a posture within the rules; `centre` is the position of its ball, m. */
bool mukca_plan_draw_anywhere(double *q, double centre[3], const mukca_plan_rules *rules,
                              mukca_random *random);

/* As mukca_plan_draw_pose, from a start near posture q: each joint is displaced with standard
 * deviation `spread` (rad or m). */
bool mukca_plan_draw_near(double *q, double spread, const double centre[3],
                          const mukca_plan_rules *rules, mukca_random *random);

/* Whether two postures differ by at least 0.2 rad or m in some joint. */
bool mukca_plan_differs(const double *a, const double *b, int n_joints);

/* ---- unknowns, and information of samples on them (state.c) ---- */

enum { MUKCA_PLAN_MOST_UNKNOWNS = MUKCA_MAX_FREE + MUKCA_MAX_EFFECTS * MUKCA_MAX_TERMS };

/* A pose in a socket with its design H[3][n + 1]: the rows of a position, by geometry and causes
 * per prior sigma. */
typedef struct {
    int socket;
    bool used;
    double q[MUKCA_MAX_JOINTS];
    double *H;
} mukca_plan_pose;

/* The posterior, with columns for the causes; the sockets are its groups. */
typedef struct {
    const mukca_chain *chain;
    /* Unknowns: parameters of the model in use, then coefficients of the causes, which are 0. */
    mukca_parameters parameters;
    int n, n_effects; /* unknowns; effects */
    double theta[MUKCA_MAX_FREE];
    mukca_geometry geometry; /* of theta */
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    double sigma[MUKCA_PLAN_MOST_UNKNOWNS]; /* prior; of parameters mukca_prior_expected */
    mukca_grouped groups;
    const mukca_plan_options *options;
    const mukca_plan_socket *sockets;
    double payload;    /* of the next samples to be designed, kg */
    double *C;         /* [terms][terms] covariance of all causes, per prior sigma */
    double *elsewhere; /* [n_elsewhere][3][n + 1] designs at the evaluation postures, less the mean
                          of their point */
    int n_elsewhere;
    double *W;     /* [n][n] sum of J'J over them, each divided by its rms error */
    bool accuracy; /* gains are computed with W instead of the determinant */
    double *G;     /* [n][8] scratch */
    mukca_pool pool;
} mukca_plan_state;

/* Initialise with the prior, no samples; task->sockets are those of the state.  Errors:
 * MUKCA_MEMORY. */
mukca_status mukca_plan_state_create(mukca_plan_state *s, const mukca_plan_task *task,
                                     const mukca_plan_options *options, mukca_error *error);

/* Design H[3][n + 1] of posture q: derivatives of the tip by the unknowns, per sigma, and minus its
 * position, m; `before` is the preceding posture, may be NULL. */
void mukca_plan_design(double *H, const mukca_plan_state *s, const double *q, int place,
                       const double *before);

/* Add a sample at `socket` (sign 1) or remove it (sign -1).  Call mukca_plan_state_refresh before
 * the next gain. */
void mukca_plan_state_row(mukca_plan_state *s, double *H, int socket, int sign);

/* Update the posterior by prior, samples and known distances. */
void mukca_plan_state_refresh(mukca_plan_state *s);

/* Information gain of a sample: the decrease of the log determinant of the covariance of the
 * geometry, or of each cause; after mukca_plan_state_weigh, of the weighted error at the evaluation
 * points. */
double mukca_plan_gain(mukca_plan_state *s, const double *H, int socket);

/* Fill state->elsewhere: positions all over the reachable workspace, and poses at each that meet
 * the rules. */
void mukca_plan_look_elsewhere(mukca_plan_state *state, const mukca_plan_rules *rules,
                               uint64_t seed);

/* Expected mean error of the ball at the evaluation points, m. */
double mukca_plan_expected(const mukca_plan_state *s);

/* Select that mean error as the criterion of gains.  Each posture is weighted by the inverse of its
 * present error: the sum of squares then decreases as the sum of errors does. */
void mukca_plan_state_weigh(mukca_plan_state *s);

/* Strength of the weakest cause: the square of its size over its standard error, which grows with
 * the number of samples; NaN without causes. */
double mukca_plan_strength(const mukca_plan_state *s);

/* ---- candidates and the choice among them (choose.c) ---- */

typedef struct {
    mukca_plan_state state;
    mukca_plan_rules rules;
    const mukca_plan_task *task;
    int recorded[MUKCA_PLAN_MAX_SOCKETS]; /* samples of each socket */
    int n_recorded, n_poses, n_chosen;
    mukca_plan_pose *poses; /* [n_poses] candidates, socket by socket */
    int *chosen;            /* [n_chosen] indices of candidates */
    double *spare;          /* scratch for the design H of one pose */
    bool ordered;           /* an effect depends on the preceding posture */
    mukca_random random;
} mukca_planner;

/* Initialise a planner for so many candidates and choices, and update its state by the recorded
 * samples.  Free its state's pool, also after errors: MUKCA_MEMORY. */
mukca_status mukca_planner_create(mukca_planner *planner, int candidates, int rows,
                                  const mukca_plan_task *task, const mukca_plan_options *options,
                                  mukca_error *error);

bool mukca_plan_stopped(const mukca_planner *planner);

/* Append up to `room` candidates for socket k; returns their number. */
int mukca_plan_draw_candidates(mukca_planner *planner, int room, int k);

/* Choose up to `rows` candidates, one at a time; then exchange them for poses of larger gain: other
 * candidates, and random poses nearby. */
void mukca_plan_choose(mukca_planner *planner, int rows);

#endif
