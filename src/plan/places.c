/* Placements around the arm: the most informative positions of a grid. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "plan/choose.h"

enum { CANDIDATES = 30, DEFAULT_ROWS = 20, AZIMUTHS = 8, CELLS = 3 * 3 * AZIMUTHS };

static void grid_place(mukca_plan_place *place, int cell, const mukca_geometry *geometry)
{
    static const double radius[3] = {0.4, 0.55, 0.7}, height[3] = {0.0, 0.2, 0.4};
    double reach = 0;
    for (int k = 0; k < geometry->n_elements; k++) reach += mukca_norm3(geometry->origin[k].p);
    const double azimuth = 2 * M_PI * (cell % AZIMUTHS) / AZIMUTHS;
    const double r = 0.75 * reach * radius[cell / AZIMUTHS % 3];
    place->centre[0] = r * cos(azimuth);
    place->centre[1] = r * sin(azimuth);
    place->centre[2] = 0.75 * reach * height[cell / (3 * AZIMUTHS)];
    place->yaw = azimuth + M_PI / 4 * (cell % 4);
}

/* Value of the last two sockets at `place` with `rows` samples: evidence, or minus the expected
 * error in m.  The state then includes these samples.  -HUGE_VAL: too few postures reach the
 * sockets. */
static double judge(mukca_planner *p, mukca_plan_place *place, double distance, int rows)
{
    mukca_plan_state *s = &p->state;
    const int first = p->n_sockets - 2;
    mukca_plan_socket *sockets = p->sockets + first;
    p->n_poses = 0;
    for (int k = 0; k < 2; k++) {
        memcpy(sockets[k].centre, place->centre, sizeof place->centre);
        sockets[k].centre[0] += (k - 0.5) * distance * cos(place->yaw);
        sockets[k].centre[1] += (k - 0.5) * distance * sin(place->yaw);
        if (mukca_plan_draw_candidates(p, CANDIDATES, first + k) < CANDIDATES / 2) return -HUGE_VAL;
    }
    mukca_plan_state_distance(s, first + 1, first, sockets[1].centre, sockets[0].centre);
    mukca_plan_choose(p, rows);
    place->expected = mukca_plan_expected(s);
    place->evidence = mukca_plan_evidence(mukca_plan_strength(s));
    return s->n_effects > 0 ? place->evidence : -place->expected;
}

/* The best placement of two more sockets, and its value (-HUGE_VAL: none); the state then includes
 * its samples.  before, best: [n][n] scratch. */
static double best_place(mukca_plan_place *place, mukca_planner *p, double distance, int rows,
                         double *before, double *best)
{
    mukca_plan_state *s = &p->state;
    const size_t bytes = (size_t)(s->n * s->n) * sizeof *s->C;
    double most = -HUGE_VAL;
    memcpy(before, s->C, bytes);
    for (int cell = 0; cell < CELLS && !mukca_plan_stopped(p); cell++) {
        mukca_plan_place trial;
        memcpy(s->C, before, bytes);
        grid_place(&trial, cell, &s->at.geometry);
        const double worth = judge(p, &trial, distance, rows);
        if (worth > most) {
            most = worth;
            *place = trial;
            memcpy(best, s->C, bytes);
        }
    }
    memcpy(s->C, best, bytes);
    return most;
}

mukca_status mukca_plan_places(mukca_plan_place *places, int *n_found, int n_places,
                               const mukca_plan_task *task, const mukca_plan_options *options,
                               mukca_error *error)
{
    mukca_planner p = {.n_sockets = 0};
    mukca_plan_state *s = &p.state;
    mukca_geometry geometry;
    const int rows = options->rows > 0 ? options->rows : DEFAULT_ROWS;
    *n_found = 0;
    mukca_geometry_set(&geometry, task->chain, task->theta);
    if (task->data)
        p.n_sockets = mukca_plan_sockets(p.sockets, MUKCA_PLAN_MAX_SOCKETS, &geometry, task->data);
    const mukca_planner_room room = {
        .sockets = p.n_sockets + 2 * n_places, .candidates = 2 * CANDIDATES, .rows = rows};
    if (n_places < 1 || room.sockets > MUKCA_PLAN_MAX_SOCKETS)
        return mukca_fail(error, MUKCA_USAGE, "places to suggest: 1 to %d with these data, not %d",
                          (MUKCA_PLAN_MAX_SOCKETS - p.n_sockets) / 2, n_places);
    mukca_status status = mukca_planner_create(&p, &room, task, options, error);
    double *before = status == MUKCA_OK ? MUKCA_TAKE(&s->pool, double, s->n * s->n) : NULL;
    double *best = status == MUKCA_OK ? MUKCA_TAKE(&s->pool, double, s->n * s->n) : NULL;
    if (status == MUKCA_OK && s->pool.failed)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory while planning");
    for (int i = 0; i < n_places && status == MUKCA_OK; i++) {
        for (int k = 0; k < 2; k++)
            p.sockets[p.n_sockets++] =
                (mukca_plan_socket){.place = -1 - i, .label = {(char)('0' + k)}};
        if (!(best_place(&places[i], &p, task->distance, rows, before, best) > -HUGE_VAL)) break;
        p.recorded[p.n_sockets - 1] = p.recorded[p.n_sockets - 2] = rows / 2;
        ++*n_found;
        if (options->progress) options->progress(options->context, (i + 1.0) / n_places);
    }
    if (status == MUKCA_OK && mukca_plan_stopped(&p))
        status = mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
    if (status == MUKCA_OK && *n_found == 0)
        status = mukca_fail(error, MUKCA_INPUT,
                            "no place around the arm was found where the ball sits in enough "
                            "poses; check the joint limits, or allow more --tilt");
    mukca_plan_state_free(s);
    return status;
}
