/* Joint angles of the experiments of Kana et al. (2022), for `mukca simulate --at`.
 *
 * usage: bench_recipes URDF sweeps|raster|targeted|targeted-test
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arm/inverse.h"
#include "io/urdf.h"

/* name, rows.  After Kana et al., Sensors 2022, 22, 2295. */
enum { SWEEPS, RASTER, TARGETED, TARGETED_TEST, RECIPES };
static const struct {
    const char *name;
    int rows;
} recipes[RECIPES] = {
    /* one joint at a time, the others at zero: 0 to pi to -pi for odd joints, half of it for even
     */
    {"sweeps", 1940},
    {"raster", 165},        /* the first two quadrants of the base, tool downwards */
    {"targeted", 58},       /* points of a small work volume, tool downwards */
    {"targeted-test", 20}}; /* other points of the same volume */

static const double pi = 3.14159265358979323846;

/* Rows evenly spaced along the path of joint after joint: from 0 to the upper end, then to the
 * lower end. */
static void sweeps(double *q, int rows, const mukca_chain *chain)
{
    const int n = chain->n_joints;
    double way[MUKCA_MAX_JOINTS][2] = {{0}}, length = 0;
    for (int j = 0; j < n; j++) {
        const mukca_element *e = &chain->element[chain->joint_element[j]];
        const double reach = e->type == MUKCA_PRISMATIC ? 0.25 : j % 2 ? pi / 2 : pi;
        way[j][0] = fmin(reach, e->upper);
        way[j][1] = fmax(-reach, e->lower);
        length += 2 * fabs(way[j][0]) + fabs(way[j][1]);
    }
    memset(q, 0, (size_t)(rows * n) * sizeof *q);
    int j = 0;
    double before = 0; /* path length of the preceding joints */
    for (int i = 0; i < rows; i++) {
        double at = length * i / rows - before;
        while (j < n - 1 && at >= 2 * fabs(way[j][0]) + fabs(way[j][1])) {
            const double whole = 2 * fabs(way[j][0]) + fabs(way[j][1]);
            at -= whole;
            before += whole;
            j++;
        }
        const double top = way[j][0], up = fabs(top);
        q[i * n + j] = at <= up ? copysign(at, top) : top - copysign(at - up, top);
    }
}

/* Halton's sequence: evenly distributed points, the same on every machine. */
static double halton(int index, int base)
{
    double f = 1, x = 0;
    for (; index > 0; index /= base) {
        f /= base;
        x += f * (index % base);
    }
    return x;
}

/* Point i of a recipe, in units of the arm's reach. */
static void point_of(double p[3], int kind, int i)
{
    if (kind == RASTER) {
        const int row = i / 11 % 5, layer = i / 55, column = row % 2 ? 10 - i % 11 : i % 11;
        p[0] = -0.40 + 0.08 * column;
        p[1] = 0.28 + 0.05 * row;
        p[2] = 0.20 + 0.10 * layer;
    } else {
        const int k = 1 + i + (kind == TARGETED_TEST ? 58 : 0);
        p[0] = 0.10 + 0.30 * halton(k, 2);
        p[1] = 0.25 + 0.25 * halton(k, 3);
        p[2] = 0.15 + 0.25 * halton(k, 5);
    }
}

/* Start postures of two configurations, with the first joint turned towards the point. */
static void posture_of(double *q, int which, const double target[3], const mukca_geometry *geometry)
{
    static const double fold[2][7] = {{0, 0.26, 3.14, -2.27, 0, 0.96, 1.57},
                                      {0, 0.6, 0, 1.4, 0, 0.6, 0}};
    double best = HUGE_VAL, first = 0;
    for (int j = 0; j < geometry->n_joints; j++) q[j] = j < 7 ? fold[which][j] : 0;
    for (int i = 0; i < 12; i++) {
        double tip[3], d[3] = {0, 0, 0};
        q[0] = pi * (i - 6) / 6;
        mukca_fk_position(tip, geometry, q, NULL);
        for (int a = 0; a < 3; a++) d[a] = tip[a] - target[a];
        if (mukca_dot3(d, d) < best) best = mukca_dot3(d, d), first = q[0];
    }
    q[0] = first;
}

static bool points(double *q, int rows, int kind, const mukca_chain *chain)
{
    const int n = chain->n_joints;
    double reach = 0;
    mukca_geometry geometry;
    mukca_frame target = {.R = {1, 0, 0, 0, -1, 0, 0, 0, -1}};
    mukca_geometry_set(&geometry, chain, NULL);
    for (int k = 0; k < chain->n_elements; k++)
        reach += sqrt(mukca_dot3(chain->element[k].xyz, chain->element[k].xyz));
    for (int i = 0; i < rows; i++) {
        double p[3], *row = q + (long)i * n;
        bool reached = false;
        point_of(p, kind, i);
        for (int a = 0; a < 3; a++) target.p[a] = p[a] * reach / 1.1873;
        for (int start = 0; start < 2 && !reached; start++) {
            const mukca_inverse_options options = {.tolerance = 1e-6};
            posture_of(row, start, target.p, &geometry);
            reached = mukca_inverse_solve(row, chain, &geometry, &target, n >= 6, &options).reached;
        }
        if (!reached) return false;
    }
    return true;
}

int main(int argc, char **argv)
{
    static mukca_chain chain;
    mukca_error error;
    int kind = 0;
    while (argc == 3 && kind < RECIPES && strcmp(recipes[kind].name, argv[2]) != 0) kind++;
    if (argc != 3 || kind == RECIPES) return 2;
    if (mukca_urdf_load(&chain, argv[1], NULL, &error) != MUKCA_OK) return 3;
    const int rows = recipes[kind].rows, n = chain.n_joints;
    double *q = calloc((size_t)(rows * n), sizeof *q);
    if (!q) return 6;
    if (kind == SWEEPS) sweeps(q, rows, &chain);
    if (kind != SWEEPS && !points(q, rows, kind, &chain)) return 3;
    for (int j = 0; j < n; j++)
        printf("%s%c", mukca_chain_joint_name(&chain, j), j + 1 < n ? '\t' : '\n');
    for (int i = 0; i < rows * n; i++) printf("%.17g%c", q[i], (i + 1) % n ? '\t' : '\n');
    free(q);
    return 0;
}
