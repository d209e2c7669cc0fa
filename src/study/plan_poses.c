/* Poses of the arm with the ball in a socket: inverse kinematics from random starts, then the
 * rules. */
#include "study/plan_poses.h"

#include <math.h>

#include "study/inverse.h"

plan_allowance plan_allow(const mukca_plan_options *o)
{
    return (plan_allowance){.tilt = o->tilt > 0 ? o->tilt : M_PI / 3,
                            .clearance = o->clearance != 0 ? o->clearance : 0.05,
                            .separation = o->separation > 0 ? o->separation : 0.2,
                            .margin = o->margin > 0 ? o->margin : 0.02};
}

bool plan_differs(const double *a, const double *b, int n_joints, double separation)
{
    for (int j = 0; j < n_joints; j++)
        if (fabs(a[j] - b[j]) >= separation) return true;
    return false;
}

/* The ball's stem (from the last joint to the tip) leans from gravity by no more than `tilt`, and
 * the joints stay `clearance` above the base's plane, or above the socket where that is lower. */
static bool allowed(const double *q, const mukca_chain *chain, const mukca_geometry *geometry,
                    const plan_allowance *allow)
{
    mukca_frame before[MUKCA_MAX_ELEMENTS], tip;
    double up[3], stem[3];
    const double weight = sqrt(mukca_dot3(chain->gravity, chain->gravity));
    if (!(weight > 0)) return true;
    mukca_fk_frames(before, &tip, geometry, q, NULL);
    const mukca_frame *last = &before[chain->joint_element[chain->n_joints - 1]];
    for (int i = 0; i < 3; i++) {
        up[i] = -chain->gravity[i] / weight;
        stem[i] = last->p[i] - tip.p[i];
    }
    const double length = sqrt(mukca_dot3(stem, stem));
    if (length > 1e-3 && allow->tilt <= M_PI && mukca_dot3(stem, up) < length * cos(allow->tilt))
        return false;
    const double floor = fmin(0, mukca_dot3(tip.p, up)) + allow->clearance;
    /* The first two joints stand where the base puts them. */
    for (int j = 2; j < chain->n_joints && !isnan(floor); j++)
        if (mukca_dot3(before[chain->joint_element[j]].p, up) < floor) return false;
    return true;
}

/* From the start q to the socket, and whether the result will do. */
static bool seat(double *q, const mukca_chain *chain, const mukca_geometry *geometry,
                 const double centre[3], const plan_allowance *allow)
{
    const mukca_inverse_options options = {.max_steps = 60};
    const mukca_frame target = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {centre[0], centre[1], centre[2]}};
    if (!mukca_inverse_solve(q, chain, geometry, &target, false, &options).reached) return false;
    for (int j = 0; j < chain->n_joints; j++) {
        const mukca_element *e = &chain->element[chain->joint_element[j]];
        if (q[j] < e->lower + allow->margin || q[j] > e->upper - allow->margin) return false;
    }
    return allowed(q, chain, geometry, allow);
}

static void draw(double *q, const mukca_chain *chain, mukca_random *random)
{
    for (int j = 0; j < chain->n_joints; j++) {
        const mukca_element *e = &chain->element[chain->joint_element[j]];
        const double low = fmax(e->lower, -M_PI), high = fmin(e->upper, M_PI);
        q[j] = low + (high - low) * mukca_random_uniform(random);
    }
}

bool plan_draw_anywhere(double *q, double centre[3], const mukca_chain *chain,
                        const mukca_geometry *geometry, const plan_allowance *allow,
                        mukca_random *random)
{
    draw(q, chain, random);
    mukca_fk_position(centre, geometry, q, NULL);
    return allowed(q, chain, geometry, allow);
}

bool plan_draw_pose(double *q, const mukca_chain *chain, const mukca_geometry *geometry,
                    const double centre[3], const plan_allowance *allow, mukca_random *random)
{
    draw(q, chain, random);
    return seat(q, chain, geometry, centre, allow);
}

bool plan_draw_near(double *q, double spread, const mukca_chain *chain,
                    const mukca_geometry *geometry, const double centre[3],
                    const plan_allowance *allow, mukca_random *random)
{
    for (int j = 0; j < chain->n_joints; j++) {
        const mukca_element *e = &chain->element[chain->joint_element[j]];
        q[j] = fmax(e->lower, fmin(e->upper, q[j] + spread * mukca_random_normal(random)));
    }
    return seat(q, chain, geometry, centre, allow);
}
