/* Random postures with the ball in a socket, within the limits of arm and tool. */
#ifndef MUKCA_PLAN_POSES_H
#define MUKCA_PLAN_POSES_H

#include "math/random.h"
#include "plan/plan.h"

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

#endif
