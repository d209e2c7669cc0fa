/* Arms and effects for tests, in a line each. */
#ifndef MUKCA_TESTS_ARMS_H
#define MUKCA_TESTS_ARMS_H

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "math/dense.h"
#include "math/random.h"
#include "mukca/chain.h"
#include "mukca/effect.h"

/* A letter per element: R turns, C turns without end, P slides, F is fixed; about and along z,
 * called NAME1, NAME2 ..., with limits of -limit and limit; origins as x y z roll pitch yaw (NULL:
 * none). */
static inline void make_chain(mukca_chain *chain, const char *types, const double (*origin)[6],
                              const char *name, double limit)
{
    memset(chain, 0, sizeof *chain);
    for (int k = 0; types[k]; k++) {
        mukca_element *e = &chain->element[chain->n_elements++];
        snprintf(e->name, sizeof e->name, "%.40s%d", name, k + 1);
        e->type = types[k] == 'F'   ? MUKCA_FIXED
                  : types[k] == 'P' ? MUKCA_PRISMATIC
                  : types[k] == 'C' ? MUKCA_CONTINUOUS
                                    : MUKCA_REVOLUTE;
        e->joint = types[k] == 'F' ? -1 : chain->n_joints;
        if (e->joint >= 0) chain->joint_element[chain->n_joints++] = k;
        e->axis[2] = 1;
        e->lower = -limit, e->upper = limit;
        if (!origin) continue;
        memcpy(e->xyz, origin[k], sizeof e->xyz);
        memcpy(e->rpy, origin[k] + 3, sizeof e->rpy);
    }
}

/* Any origin, of some `size` m, and any axis, or (`upright`) that about z. */
static inline void scatter_element(mukca_element *e, double size, bool upright,
                                   mukca_random *random)
{
    for (int i = 0; i < 3; i++) {
        e->xyz[i] = size * mukca_random_normal(random);
        e->rpy[i] = mukca_random_normal(random);
        e->axis[i] = upright ? i == 2 : mukca_random_normal(random);
    }
    const double length = mukca_norm3(e->axis);
    for (int i = 0; i < 3; i++) e->axis[i] /= length;
}

/* An effect of one term; joint -1: of none. */
static inline mukca_effect make_effect(mukca_effect_kind kind, int joint, double coefficient)
{
    return (mukca_effect){
        .kind = kind, .joint = joint, .placement = -1, .terms = 1, .coefficient = {coefficient}};
}

/* Mean distance of points from others, moved rigidly to them; *rms (may be NULL). */
static inline double rigid_error(double *rms, double (*to)[3], double (*from)[3], int n)
{
    mukca_frame best;
    double sum = 0, squares = 0;
    mukca_frame_nearest(&best, to[0], from[0], 3, n);
    for (int i = 0; i < n; i++) {
        double at[3];
        mukca_mat3_vec(at, best.R, from[i]);
        for (int k = 0; k < 3; k++) at[k] += best.p[k];
        sum += mukca_distance3(at, to[i]) / n;
        squares += pow(mukca_distance3(at, to[i]), 2) / n;
    }
    if (rms) *rms = sqrt(squares);
    return sum;
}

#endif
