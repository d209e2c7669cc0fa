/* Poses of the arm with the ball in a socket: inverse kinematics from random starts, then the
 * rules. */
#include "plan/poses.h"

#include <math.h>

#include "arm/inverse.h"

/* How a pose stands to gravity: the lean of the ball's stem (from the last joint to the tip), rad,
 * 0 where there is no stem, and the height of the lowest joint beyond the first two, which stand
 * where the base puts them, above the base's plane or above the ball where that is lower, m. */
typedef struct {
    double lean, clear;
} standing;

static standing stand(const double *q, const mukca_chain *chain, const mukca_geometry *geometry)
{
    mukca_frame before[MUKCA_MAX_ELEMENTS], tip;
    double up[3], stem[3];
    standing s = {.lean = 0, .clear = HUGE_VAL};
    const double weight = sqrt(mukca_dot3(chain->gravity, chain->gravity));
    if (!(weight > 0)) return s;
    mukca_fk_frames(before, &tip, geometry, q, NULL);
    const mukca_frame *last = &before[chain->joint_element[chain->n_joints - 1]];
    for (int i = 0; i < 3; i++) {
        up[i] = -chain->gravity[i] / weight;
        stem[i] = last->p[i] - tip.p[i];
    }
    const double length = sqrt(mukca_dot3(stem, stem));
    if (length > 1e-3) s.lean = acos(fmax(-1, fmin(1, mukca_dot3(stem, up) / length)));
    const double floor = fmin(0, mukca_dot3(tip.p, up));
    for (int j = 2; j < chain->n_joints; j++)
        s.clear = fmin(s.clear, mukca_dot3(before[chain->joint_element[j]].p, up) - floor);
    return s;
}

plan_allowance plan_allow(const mukca_plan_options *o, const mukca_chain *chain,
                          const mukca_geometry *geometry, const mukca_dataset *data)
{
    plan_allowance allow = {.tilt = o->tilt > 0 ? o->tilt : M_PI / 3,
                            .clearance = o->clearance != 0 ? o->clearance : 0.05,
                            .separation = o->separation > 0 ? o->separation : 0.2,
                            .margin = o->margin > 0 ? o->margin : 0.02};
    for (int r = 0; data && r < data->n_rows; r++) {
        const standing s = stand(data->q + r * data->n_joints, chain, geometry);
        if (!(o->tilt > 0)) allow.tilt = fmax(allow.tilt, s.lean);
        if (o->clearance == 0) allow.clearance = fmin(allow.clearance, s.clear);
    }
    return allow;
}

bool plan_differs(const double *a, const double *b, int n_joints, double separation)
{
    for (int j = 0; j < n_joints; j++)
        if (fabs(a[j] - b[j]) >= separation) return true;
    return false;
}

static bool allowed(const double *q, const mukca_chain *chain, const mukca_geometry *geometry,
                    const plan_allowance *allow)
{
    const standing s = stand(q, chain, geometry);
    return s.lean <= allow->tilt && !(s.clear < allow->clearance);
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
