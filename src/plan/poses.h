/* Postures with the ball in a socket, drawn at random within the limits of arm and tool. */
#ifndef MUKCA_PLAN_POSES_H
#define MUKCA_PLAN_POSES_H

#include "math/random.h"
#include "plan/plan.h"

/* The arm and what a posture must keep, as in mukca_plan_options with the defaults filled in. */
typedef struct {
    const mukca_chain *chain;
    const mukca_geometry *geometry;
    double tilt, clearance, separation, margin;
} mukca_plan_rules;

/* Rules of `options`; where those leave a default, all that a recorded row did is allowed, too.
 * `data` may be NULL; chain and geometry must outlive the rules. */
void mukca_plan_rules_set(mukca_plan_rules *rules, const mukca_chain *chain,
                          const mukca_geometry *geometry, const mukca_plan_options *options,
                          const mukca_dataset *data);

/* One posture q[n_joints] with the tip at `centre` (m), anywhere; false when this draw failed. */
bool mukca_plan_draw_pose(double *q, const double centre[3], const mukca_plan_rules *rules,
                          mukca_random *random);

/* A random posture within the rules, and the position of its ball. */
bool mukca_plan_draw_anywhere(double *q, double centre[3], const mukca_plan_rules *rules,
                              mukca_random *random);

/* As mukca_plan_draw_pose, near the posture in q: its joints move by `spread` (rad or m) first. */
bool mukca_plan_draw_near(double *q, double spread, const double centre[3],
                          const mukca_plan_rules *rules, mukca_random *random);

/* Whether two postures differ by `separation` in some joint. */
bool mukca_plan_differs(const double *a, const double *b, int n_joints, double separation);

#endif
