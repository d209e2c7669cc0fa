/* Random numbers of a simulation: one stream per purpose, and random postures. */
#include <math.h>

#include "simulate/simulate.h"

void mukca_simulate_seed(mukca_random *random, uint64_t seed, mukca_draw purpose)
{
    mukca_random_seed(random, seed ^ ((uint64_t)purpose * 0xd1b54a32d192ed03u));
}

static double range_of(const mukca_element *e, double *lower)
{
    const double free = e->type == MUKCA_PRISMATIC ? 0.5 : 3.141592653589793;
    *lower = fmax(e->lower, -free);
    return fmin(e->upper, free) - *lower;
}

void mukca_simulate_posture(double *q, const mukca_chain *chain, mukca_random *random)
{
    for (int j = 0; j < chain->n_joints; j++) {
        double lower, range = range_of(&chain->element[chain->joint_element[j]], &lower);
        q[j] = lower + range * (0.02 + 0.96 * mukca_random_uniform(random));
    }
}
