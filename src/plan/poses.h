/* Poses of the arm with the ball in a socket, drawn at random within what arm and tool allow. */
#ifndef MUKCA_PLAN_POSES_H
#define MUKCA_PLAN_POSES_H

#include "math/random.h"
#include "plan/plan.h"

typedef struct {
    double tilt, clearance, separation, margin; /* as in mukca_plan_options, defaults filled in */
} plan_allowance;

/* What `options` allow; where they leave a default, all that a recorded row did (data may be NULL)
 * is allowed, too. */
plan_allowance plan_allow(const mukca_plan_options *options, const mukca_chain *chain,
                          const mukca_geometry *geometry, const mukca_dataset *data);

/* One pose q[n_joints] with the tip at `centre` (m), anywhere; false when this draw led to none. */
bool plan_draw_pose(double *q, const mukca_chain *chain, const mukca_geometry *geometry,
                    const double centre[3], const plan_allowance *allow, mukca_random *random);

/* A random posture that the rules allow, and where its ball is. */
bool plan_draw_anywhere(double *q, double centre[3], const mukca_chain *chain,
                        const mukca_geometry *geometry, const plan_allowance *allow,
                        mukca_random *random);

/* As plan_draw_pose, near the pose that q holds: joints moved by some `spread` (rad or m) first. */
bool plan_draw_near(double *q, double spread, const mukca_chain *chain,
                    const mukca_geometry *geometry, const double centre[3],
                    const plan_allowance *allow, mukca_random *random);

/* Whether two poses differ by `separation` in some joint. */
bool plan_differs(const double *a, const double *b, int n_joints, double separation);

#endif
