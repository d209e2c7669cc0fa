/* Placements of a simulated tool: reachable in many postures, far from each other. */
#include <math.h>

#include "arm/inverse.h"
#include "simulate/simulate.h"

enum { CANDIDATES = 32, TRIES = 10, SEARCH = 200 };
static const double margin = 0.03; /* m, reserve for errors and effects */

/* Fraction of random starts from which inverse kinematics reaches a point `margin` beyond each
 * socket; the smaller of both sockets. */
static double reachable(const mukca_place *place, const mukca_chain *chain,
                        const mukca_geometry *geometry, double distance, mukca_random *random)
{
    int reached[2] = {0, 0};
    for (int i = 0; i < 2 * TRIES; i++) {
        double q[MUKCA_MAX_JOINTS];
        mukca_frame target = place->pose;
        for (int a = 0; a < 3; a++)
            target.p[a] += (i % 2 - 0.5) * (distance + 2 * margin) * place->pose.R[3 * a];
        mukca_simulate_posture(q, chain, random);
        reached[i % 2] +=
            mukca_inverse_solve(q, chain, geometry, &target, false, &(mukca_inverse_options){0})
                .reached;
    }
    return fmin(reached[0], reached[1]) / TRIES;
}

/* Draw a placement at the ball of a random posture, above the base plane if one of SEARCH tries
 * is. */
static void draw(mukca_place *place, const mukca_chain *chain, const mukca_geometry *geometry,
                 mukca_random *random)
{
    double turned[4];
    for (int try = 0; try < SEARCH; try++) {
        double q[MUKCA_MAX_JOINTS];
        mukca_simulate_posture(q, chain, random);
        mukca_fk_position(place->pose.p, geometry, q, NULL);
        if (mukca_dot3(place->pose.p, chain->gravity) < -0.05 * 9.8) break;
    }
    for (int i = 0; i < 4; i++) turned[i] = mukca_random_normal(random);
    mukca_rotation_from_quaternion(place->pose.R, turned);
    place->placed = true;
}

mukca_status mukca_simulate_places(mukca_place *places, int n_places, const mukca_chain *chain,
                                   double distance, uint64_t seed, mukca_error *error)
{
    mukca_random random;
    mukca_geometry geometry;
    mukca_place candidates[CANDIDATES];
    double reached[CANDIDATES], best = 0;
    mukca_simulate_seed(&random, seed, MUKCA_DRAW_PLACES);
    mukca_geometry_set(&geometry, chain, NULL);
    for (int i = 0; i < n_places; i++) {
        if (places[i].placed) continue;
        best = 0;
        for (int c = 0; c < CANDIDATES; c++) {
            draw(&candidates[c], chain, &geometry, &random);
            reached[c] = reachable(&candidates[c], chain, &geometry, distance, &random);
            best = fmax(best, reached[c]);
        }
        if (best <= 0)
            return mukca_fail(error, MUKCA_INPUT,
                              "found no place for the tool that the arm reaches within its limits; "
                              "check the limits of the URDF, or give places");
        int chosen = -1;
        double farthest = -1;
        for (int c = 0; c < CANDIDATES; c++) {
            double far = 10; /* m, to the nearest of the others so far; at most this */
            for (int k = 0; k < n_places; k++)
                if (places[k].placed)
                    far = fmin(far, mukca_distance3(places[k].pose.p, candidates[c].pose.p));
            if (reached[c] < 0.7 * best || far <= farthest) continue;
            farthest = far;
            chosen = c;
        }
        places[i].pose = candidates[chosen].pose;
        places[i].placed = true;
    }
    return MUKCA_OK;
}

/* ---- random numbers of a simulation: one stream per purpose, and random postures ---- */

void mukca_simulate_seed(mukca_random *random, uint64_t seed, mukca_draw purpose)
{
    *random = mukca_random_seeded(seed ^ ((uint64_t)purpose * 0xd1b54a32d192ed03u));
}

void mukca_simulate_posture(double *q, const mukca_chain *chain, mukca_random *random)
{
    for (int j = 0; j < chain->n_joints; j++) {
        const mukca_element *e = &chain->element[chain->joint_element[j]];
        const double free = e->type == MUKCA_PRISMATIC ? 0.5 : M_PI;
        const double lower = fmax(e->lower, -free), range = fmin(e->upper, free) - lower;
        q[j] = lower + range * (0.02 + 0.96 * mukca_random_uniform(random));
    }
}
