/* Candidates and the choice among them, for mukca_plan_run and mukca_plan_places. */
#ifndef MUKCA_PLAN_CHOOSE_H
#define MUKCA_PLAN_CHOOSE_H

#include "plan/poses.h"
#include "plan/state.h"

typedef struct {
    mukca_plan_state state;
    mukca_plan_rules rules;
    const mukca_dataset *data;
    const mukca_plan_socket *sockets;
    int n_sockets, n_poses;
    mukca_plan_pose *poses; /* [n_poses] candidates, by socket */
    int tried;
    double *spare; /* an H */
    bool ordered;  /* a cause depends on where the arm comes from */
} mukca_planner;

bool mukca_plan_stopped(const mukca_plan_options *options);

/* Fill poses[room] with candidates for socket k; returns how many were found. */
int mukca_plan_draw_candidates(mukca_planner *p, mukca_plan_pose *poses, int room, int k,
                               mukca_random *random);

/* Take what the recorded rows tell, and the distances between the plan's sockets; count[n_sockets]
 * gets the rows of each; H[3][n_known] is scratch.  Returns the number of rows. */
int mukca_plan_take_recorded(mukca_planner *p, double *H, int *count);

/* Choose `rows` candidates one by one, chosen[rows]; recorded[n_sockets] rows are there already.
 * Returns how many were found. */
int mukca_plan_choose(mukca_planner *p, int *chosen, int rows, const int *recorded);

/* Exchange chosen poses for better ones, from the candidates and from their own surroundings. */
void mukca_plan_exchange(mukca_planner *p, int *chosen, int n_chosen, mukca_random *random);

/* The grid of places around the arm: the middle of cell 0 .. PLAN_CELLS - 1, and the direction from
 * its first socket to the other. */
enum { PLAN_AZIMUTHS = 8, PLAN_CELLS = 3 * 3 * PLAN_AZIMUTHS };
void mukca_plan_grid_place(double centre[3], double *yaw, int cell, const mukca_plan_state *s);

/* Fill s->elsewhere: spots all over what the arm reaches by the rules, and poses at each. */
void mukca_plan_look_elsewhere(mukca_plan_state *s, const mukca_plan_rules *rules, uint64_t seed);

#endif
