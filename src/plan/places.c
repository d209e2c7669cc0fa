/* Places for the tool around the arm: a grid, what the error is there, and which are worth most. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "plan/choose.h"

enum { SPOTS = 50, POSES = 12, PLACE_CANDIDATES = 30, PLACE_ROWS = 20 };

void plan_grid_place(double centre[3], double *yaw, int cell, const plan_state *s)
{
    static const double radius[3] = {0.4, 0.55, 0.7}, height[3] = {0.0, 0.2, 0.4};
    double reach = 0;
    for (int k = 0; k < s->chain->n_elements; k++)
        reach += sqrt(mukca_dot3(s->geometry.origin[k].p, s->geometry.origin[k].p));
    const double azimuth = 2 * M_PI * (cell % PLAN_AZIMUTHS) / PLAN_AZIMUTHS;
    const double r = 0.75 * reach * radius[cell / PLAN_AZIMUTHS % 3];
    centre[0] = r * cos(azimuth);
    centre[1] = r * sin(azimuth);
    centre[2] = 0.75 * reach * height[cell / (3 * PLAN_AZIMUTHS)];
    *yaw = azimuth + M_PI / 4 * (cell % 4);
}

void plan_look_elsewhere(plan_state *s, const plan_allowance *allow, uint64_t seed)
{
    const int p = s->n_geometry, k = s->n_known;
    double *H = MUKCA_TAKE(&s->pool, double, POSES * 3 * k);
    s->elsewhere = MUKCA_TAKE(&s->pool, double, SPOTS *POSES * 3 * p);
    mukca_random random;
    mukca_random_seed(&random, seed + 1);
    if (s->pool.failed) return;
    for (int spot = 0, tries = 0; spot < SPOTS && tries < 20 * SPOTS; tries++) {
        double q[MUKCA_MAX_JOINTS], centre[3];
        int found = 0;
        if (!plan_draw_anywhere(q, centre, s->chain, &s->geometry, allow, &random)) continue;
        for (int t = 0; t < 3 * POSES && found < POSES; t++)
            if (plan_draw_pose(q, s->chain, &s->geometry, centre, allow, &random))
                plan_design(H + 3 * k * found++, s, q, 0, NULL);
        if (found < POSES / 2) continue;
        spot++;
        for (int d = 0; d < 3; d++)
            for (int c = 0; c < p; c++) {
                double mean = 0;
                for (int f = 0; f < found; f++) mean += H[(3 * f + d) * k + c] / found;
                for (int f = 0; f < found; f++)
                    s->elsewhere[(3 * (s->n_elsewhere + f) + d) * p + c] =
                        H[(3 * f + d) * k + c] - mean;
            }
        s->n_elsewhere += found;
    }
}

/* Sockets of cell `cell`, symmetric about its middle. */
static void seat(mukca_plan_socket sockets[2], int cell, double distance, const plan_state *s)
{
    double centre[3], yaw;
    plan_grid_place(centre, &yaw, cell, s);
    for (int k = 0; k < 2; k++) {
        memcpy(sockets[k].centre, centre, sizeof centre);
        sockets[k].centre[0] += (k - 0.5) * distance * cos(yaw);
        sockets[k].centre[1] += (k - 0.5) * distance * sin(yaw);
    }
}

/* Put the candidates of a cell into the slots of the last two sockets; false where it is not
 * reached. */
static bool fill(planner *p, mukca_plan_socket *last, int cell, double distance,
                 mukca_random *random)
{
    seat(last, cell, distance, &p->state);
    p->n_poses = 0;
    for (int k = p->n_sockets - 2; k < p->n_sockets; k++) {
        const int found =
            plan_draw_candidates(p, p->poses + p->n_poses, PLACE_CANDIDATES, k, random);
        if (found < PLACE_CANDIDATES / 2) return false;
        p->n_poses += found;
    }
    return true;
}

mukca_status mukca_plan_places(mukca_plan_place *places, int *n_found, int n_places,
                               const mukca_chain *chain, const double *theta,
                               const mukca_dataset *data, double distance,
                               const mukca_plan_options *options, mukca_error *error)
{
    mukca_plan_socket sockets[MUKCA_PLAN_MAX_SOCKETS];
    int recorded[MUKCA_PLAN_MAX_SOCKETS] = {0};
    mukca_geometry geometry;
    const int rows = options->rows > 0 ? options->rows : PLACE_ROWS;
    *n_found = 0;
    mukca_geometry_set(&geometry, chain, theta);
    const int old = data ? mukca_plan_sockets(sockets, MUKCA_PLAN_MAX_SOCKETS, &geometry, data) : 0;
    const int all = old + 2 * n_places;
    if (n_places < 1 || all > MUKCA_PLAN_MAX_SOCKETS)
        return mukca_fail(error, MUKCA_USAGE, "places to suggest: 1 to %d with these data, not %d",
                          (MUKCA_PLAN_MAX_SOCKETS - old) / 2, n_places);
    for (int k = old; k < all; k++) {
        sockets[k] = (mukca_plan_socket){.place = -1 - (k - old) / 2};
        snprintf(sockets[k].label, sizeof sockets[k].label, "%d", (k - old) % 2);
    }
    planner p = {.data = data, .sockets = sockets, .n_sockets = old};
    mukca_status status = plan_state_create(&p.state, chain, theta, all, options, error);
    if (status != MUKCA_OK) return status;
    plan_state *s = &p.state;
    const size_t bytes = (size_t)(s->n * s->n) * sizeof *s->C;
    p.allow = plan_allow(options, chain, &s->geometry, data);
    p.poses = MUKCA_TAKE(&s->pool, plan_pose, 2 * PLACE_CANDIDATES);
    for (int i = 0; i < 2 * PLACE_CANDIDATES && p.poses; i++)
        p.poses[i].H = MUKCA_TAKE(&s->pool, double, 3 * s->n_known);
    double *H = MUKCA_TAKE(&s->pool, double, 3 * s->n_known);
    double *before = mukca_pool_take(&s->pool, bytes, 1),
           *best = mukca_pool_take(&s->pool, bytes, 1);
    int *chosen = MUKCA_TAKE(&s->pool, int, rows + all);
    plan_look_elsewhere(s, &p.allow, options->seed);
    if (s->pool.failed) {
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory while planning");
        goto out;
    }
    plan_take_recorded(&p, H, recorded);
    mukca_random random;
    mukca_random_seed(&random, options->seed);
    for (int i = 0; i < n_places; i++) {
        mukca_plan_place *place = &places[i];
        double most = -HUGE_VAL;
        p.n_sockets += 2;
        memcpy(before, s->C, bytes);
        for (int cell = 0; cell < PLAN_CELLS && !plan_stopped(options); cell++) {
            memcpy(s->C, before, bytes);
            if (!fill(&p, sockets + p.n_sockets - 2, cell, distance, &random)) continue;
            plan_state_distance(s, p.n_sockets - 1, p.n_sockets - 2,
                                sockets[p.n_sockets - 1].centre, sockets[p.n_sockets - 2].centre);
            plan_choose(&p, chosen, rows, recorded);
            const double worth =
                s->n_effects > 0 ? plan_evidence(plan_strength(s)) : -plan_expected(s);
            if (worth > most) {
                most = worth;
                place->expected = plan_expected(s);
                place->evidence = plan_evidence(plan_strength(s));
                plan_grid_place(place->centre, &place->yaw, cell, s);
                memcpy(best, s->C, bytes);
            }
            if (options->progress)
                options->progress(options->context, (i + (double)cell / PLAN_CELLS) / n_places);
        }
        if (plan_stopped(options)) {
            status = mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
            goto out;
        }
        if (!isfinite(most)) break;
        memcpy(s->C, best, bytes);
        recorded[p.n_sockets - 1] = recorded[p.n_sockets - 2] = rows / 2;
        ++*n_found;
    }
    if (*n_found == 0)
        status =
            mukca_fail(error, MUKCA_INPUT,
                       "no place around the arm was found where the ball sits in enough poses; "
                       "check the joint limits, or allow more --tilt");
out:
    plan_state_free(s);
    return status;
}
