/* Poses with the ball in a socket: inverse kinematics from random starts, then the rules. */
#include "plan/choose.h"

#include <math.h>

#include "arm/inverse.h"

/* Distance of the postures of a session in some joint, and from the mechanical stops; rad or m. */
static const double separation = 0.2, margin = 0.02;

/* A pose relative to gravity.  lean: angle of the ball's stem (from the last joint to the tip),
 * rad, 0 without a stem.  clear: height of the lowest joint, m, above the base's plane or above the
 * ball if that is lower; the first two joints are not counted, as the base fixes their height. */
typedef struct {
    double lean, clear;
} attitude;

static attitude attitude_of(const double *q, const mukca_plan_rules *rules)
{
    const mukca_chain *chain = rules->chain;
    mukca_frame before[MUKCA_MAX_ELEMENTS], tip;
    double up[3], stem[3];
    attitude s = {.lean = 0, .clear = HUGE_VAL};
    const double weight = mukca_norm3(chain->gravity);
    if (!(weight > 0)) return s;
    mukca_fk_frames(before, &tip, rules->geometry, q, NULL);
    const mukca_frame *last = &before[chain->joint_element[chain->n_joints - 1]];
    for (int i = 0; i < 3; i++) {
        up[i] = -chain->gravity[i] / weight;
        stem[i] = last->p[i] - tip.p[i];
    }
    const double length = mukca_norm3(stem);
    if (length > 1e-3) s.lean = acos(fmax(-1, fmin(1, mukca_dot3(stem, up) / length)));
    const double floor = fmin(0, mukca_dot3(tip.p, up));
    for (int j = 2; j < chain->n_joints; j++)
        s.clear = fmin(s.clear, mukca_dot3(before[chain->joint_element[j]].p, up) - floor);
    return s;
}

void mukca_plan_rules_set(mukca_plan_rules *rules, const mukca_chain *chain,
                          const mukca_geometry *geometry, const mukca_plan_options *o,
                          const mukca_dataset *data)
{
    /* Sources of the defaults: a printed socket holds the ball up to a lean of some 60 degrees; 5
     * cm keep a joint's housing off the table. */
    *rules = (mukca_plan_rules){.chain = chain,
                                .geometry = geometry,
                                .tilt = o->tilt > 0 ? o->tilt : M_PI / 3,
                                .clearance = 0.05};
    for (int r = 0; data && r < data->n_rows; r++) {
        const attitude s = attitude_of(data->q + r * data->n_joints, rules);
        if (!(o->tilt > 0)) rules->tilt = fmax(rules->tilt, s.lean);
        rules->clearance = fmin(rules->clearance, s.clear);
    }
}

bool mukca_plan_differs(const double *a, const double *b, int n_joints)
{
    return mukca_largest_difference(a, b, n_joints) >= separation;
}

static bool allowed(const double *q, const mukca_plan_rules *rules)
{
    const attitude s = attitude_of(q, rules);
    return s.lean <= rules->tilt && !(s.clear < rules->clearance);
}

/* Move the tip from start q to the socket; whether the result meets the rules. */
static bool seat(double *q, const double centre[3], const mukca_plan_rules *rules)
{
    const mukca_chain *chain = rules->chain;
    const mukca_inverse_options options = {.max_steps = 60};
    const mukca_frame target = {MUKCA_IDENTITY, {centre[0], centre[1], centre[2]}};
    if (!mukca_inverse_solve(q, chain, rules->geometry, &target, false, &options).reached)
        return false;
    for (int j = 0; j < chain->n_joints; j++) {
        const mukca_element *e = &chain->element[chain->joint_element[j]];
        if (q[j] < e->lower + margin || q[j] > e->upper - margin) return false;
    }
    return allowed(q, rules);
}

static void draw(double *q, const mukca_chain *chain, mukca_random *random)
{
    for (int j = 0; j < chain->n_joints; j++) {
        const mukca_element *e = &chain->element[chain->joint_element[j]];
        const double low = fmax(e->lower, -M_PI), high = fmin(e->upper, M_PI);
        q[j] = low + (high - low) * mukca_random_uniform(random);
    }
}

bool mukca_plan_draw_anywhere(double *q, double centre[3], const mukca_plan_rules *rules,
                              mukca_random *random)
{
    draw(q, rules->chain, random);
    mukca_fk_position(centre, rules->geometry, q, NULL);
    return allowed(q, rules);
}

bool mukca_plan_draw_pose(double *q, const double centre[3], const mukca_plan_rules *rules,
                          mukca_random *random)
{
    draw(q, rules->chain, random);
    return seat(q, centre, rules);
}

bool mukca_plan_draw_near(double *q, double spread, const double centre[3],
                          const mukca_plan_rules *rules, mukca_random *random)
{
    const mukca_chain *chain = rules->chain;
    for (int j = 0; j < chain->n_joints; j++) {
        const mukca_element *e = &chain->element[chain->joint_element[j]];
        q[j] = fmax(e->lower, fmin(e->upper, q[j] + spread * mukca_random_normal(random)));
    }
    return seat(q, centre, rules);
}
