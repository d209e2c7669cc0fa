/* Candidates and the choice among them, shared by mukca_plan_run and mukca_plan_places. */
#ifndef MUKCA_PLAN_CHOOSE_H
#define MUKCA_PLAN_CHOOSE_H

#include "math/random.h"
#include "plan/state.h"

/* ---- random postures with the ball in a socket, within the limits of arm and tool (poses.c) ----
 */

/* The arm and the rules for its postures: mukca_plan_options with the defaults filled in. */
typedef struct {
    const mukca_chain *chain;
    const mukca_geometry *geometry;
    double tilt, clearance, separation, margin;
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

/* Whether two postures differ by at least `separation` in some joint. */
bool mukca_plan_differs(const double *a, const double *b, int n_joints, double separation);

/* ---- candidates and the choice among them ---- */

typedef struct {
    mukca_plan_state state;
    mukca_plan_rules rules;
    const mukca_dataset *data;
    mukca_plan_socket sockets[MUKCA_PLAN_MAX_SOCKETS];
    int recorded[MUKCA_PLAN_MAX_SOCKETS]; /* samples of each socket */
    int n_sockets, n_recorded, n_poses, n_chosen, tried;
    mukca_plan_pose *poses; /* [n_poses] candidates, socket by socket */
    int *chosen;            /* [n_chosen] indices of candidates */
    double *spare;          /* scratch for the design H of one pose */
    bool ordered;           /* an effect depends on the preceding posture */
    mukca_random random;
} mukca_planner;

/* Capacity of a planner: sockets, candidates, choices. */
typedef struct {
    int sockets, candidates, rows;
} mukca_planner_room;

/* Initialise a planner, zeroed except for its n_sockets sockets, and update its state by the
 * recorded samples.  Free its state with mukca_plan_state_free, also after errors: MUKCA_MEMORY,
 * MUKCA_USAGE. */
mukca_status mukca_planner_create(mukca_planner *planner, const mukca_planner_room *room,
                                  const mukca_plan_task *task, const mukca_plan_options *options,
                                  mukca_error *error);

bool mukca_plan_stopped(const mukca_planner *planner);

/* Fill state->elsewhere: positions all over the reachable workspace, and poses at each that meet
 * the rules. */
void mukca_plan_look_elsewhere(mukca_plan_state *state, const mukca_plan_rules *rules,
                               uint64_t seed);

/* Append up to `room` candidates for socket k; returns their number. */
int mukca_plan_draw_candidates(mukca_planner *planner, int room, int k);

/* Choose up to `rows` candidates, one at a time. */
void mukca_plan_choose(mukca_planner *planner, int rows);

/* Exchange chosen poses for poses of larger gain: other candidates, and random poses nearby. */
void mukca_plan_exchange(mukca_planner *planner);

#endif
