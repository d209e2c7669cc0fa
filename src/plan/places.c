/* Places for the tool around the arm: a grid, what the error is there, and which are worth most. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "plan/choose.h"

enum { PLACE_CANDIDATES = 30, PLACE_ROWS = 20 };

void mukca_plan_grid_place(double centre[3], double *yaw, int cell, const mukca_plan_state *s)
{
    static const double radius[3] = {0.4, 0.55, 0.7}, height[3] = {0.0, 0.2, 0.4};
    double reach = 0;
    for (int k = 0; k < s->at.chain->n_elements; k++)
        reach += sqrt(mukca_dot3(s->at.geometry.origin[k].p, s->at.geometry.origin[k].p));
    const double azimuth = 2 * M_PI * (cell % PLAN_AZIMUTHS) / PLAN_AZIMUTHS;
    const double r = 0.75 * reach * radius[cell / PLAN_AZIMUTHS % 3];
    centre[0] = r * cos(azimuth);
    centre[1] = r * sin(azimuth);
    centre[2] = 0.75 * reach * height[cell / (3 * PLAN_AZIMUTHS)];
    *yaw = azimuth + M_PI / 4 * (cell % 4);
}

/* Sockets of cell `cell`, symmetric about its middle. */
static void seat(mukca_plan_socket sockets[2], int cell, double distance, const mukca_plan_state *s)
{
    double centre[3], yaw;
    mukca_plan_grid_place(centre, &yaw, cell, s);
    for (int k = 0; k < 2; k++) {
        memcpy(sockets[k].centre, centre, sizeof centre);
        sockets[k].centre[0] += (k - 0.5) * distance * cos(yaw);
        sockets[k].centre[1] += (k - 0.5) * distance * sin(yaw);
    }
}

/* Put the candidates of a cell into the slots of the last two sockets; false where it is not
 * reached. */
static bool fill(mukca_planner *p, mukca_plan_socket *last, int cell, double distance,
                 mukca_random *random)
{
    seat(last, cell, distance, &p->state);
    p->n_poses = 0;
    for (int k = p->n_sockets - 2; k < p->n_sockets; k++) {
        const int found =
            mukca_plan_draw_candidates(p, p->poses + p->n_poses, PLACE_CANDIDATES, k, random);
        if (found < PLACE_CANDIDATES / 2) return false;
        p->n_poses += found;
    }
    return true;
}

mukca_status mukca_plan_places(mukca_plan_place *places, int *n_found, int n_places,
                               const mukca_plan_task *task, const mukca_plan_options *options,
                               mukca_error *error)
{
    const mukca_dataset *data = task->data;
    mukca_plan_socket sockets[MUKCA_PLAN_MAX_SOCKETS];
    int recorded[MUKCA_PLAN_MAX_SOCKETS] = {0};
    mukca_geometry geometry;
    const int rows = options->rows > 0 ? options->rows : PLACE_ROWS;
    *n_found = 0;
    mukca_geometry_set(&geometry, task->chain, task->theta);
    const int old = data ? mukca_plan_sockets(sockets, MUKCA_PLAN_MAX_SOCKETS, &geometry, data) : 0;
    const int all = old + 2 * n_places;
    if (n_places < 1 || all > MUKCA_PLAN_MAX_SOCKETS)
        return mukca_fail(error, MUKCA_USAGE, "places to suggest: 1 to %d with these data, not %d",
                          (MUKCA_PLAN_MAX_SOCKETS - old) / 2, n_places);
    for (int k = old; k < all; k++) {
        sockets[k] = (mukca_plan_socket){.place = -1 - (k - old) / 2};
        snprintf(sockets[k].label, sizeof sockets[k].label, "%d", (k - old) % 2);
    }
    mukca_planner p = {.data = data, .sockets = sockets, .n_sockets = old};
    mukca_status status = mukca_plan_state_create(&p.state, task, all, options, error);
    if (status != MUKCA_OK) return status;
    mukca_plan_state *s = &p.state;
    const size_t bytes = (size_t)(s->n * s->n) * sizeof *s->C;
    mukca_plan_rules_set(&p.rules, s->at.chain, &s->at.geometry, options, data);
    p.poses = MUKCA_TAKE(&s->pool, mukca_plan_pose, 2 * PLACE_CANDIDATES);
    for (int i = 0; i < 2 * PLACE_CANDIDATES && p.poses; i++)
        p.poses[i].H = MUKCA_TAKE(&s->pool, double, 3 * s->n_known);
    double *H = MUKCA_TAKE(&s->pool, double, 3 * s->n_known);
    double *before = mukca_pool_take(&s->pool, bytes, 1),
           *best = mukca_pool_take(&s->pool, bytes, 1);
    int *chosen = MUKCA_TAKE(&s->pool, int, rows + all);
    mukca_plan_look_elsewhere(s, &p.rules, options->seed);
    if (s->pool.failed) {
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory while planning");
        goto out;
    }
    mukca_plan_take_recorded(&p, H, recorded);
    mukca_random random;
    mukca_random_seed(&random, options->seed);
    for (int i = 0; i < n_places; i++) {
        mukca_plan_place *place = &places[i];
        double most = -HUGE_VAL;
        p.n_sockets += 2;
        memcpy(before, s->C, bytes);
        for (int cell = 0; cell < PLAN_CELLS && !mukca_plan_stopped(options); cell++) {
            memcpy(s->C, before, bytes);
            if (!fill(&p, sockets + p.n_sockets - 2, cell, task->distance, &random)) continue;
            mukca_plan_state_distance(s, p.n_sockets - 1, p.n_sockets - 2,
                                      sockets[p.n_sockets - 1].centre,
                                      sockets[p.n_sockets - 2].centre);
            mukca_plan_choose(&p, chosen, rows, recorded);
            const double worth = s->n_effects > 0 ? mukca_plan_evidence(mukca_plan_strength(s))
                                                  : -mukca_plan_expected(s);
            if (worth > most) {
                most = worth;
                place->expected = mukca_plan_expected(s);
                place->evidence = mukca_plan_evidence(mukca_plan_strength(s));
                mukca_plan_grid_place(place->centre, &place->yaw, cell, s);
                memcpy(best, s->C, bytes);
            }
            if (options->progress)
                options->progress(options->context, (i + (double)cell / PLAN_CELLS) / n_places);
        }
        if (mukca_plan_stopped(options)) {
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
    mukca_plan_state_free(s);
    return status;
}
