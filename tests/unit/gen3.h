/* The Kinova Gen3 of the paper's Table 2, and its Table 3, for tests. */
#ifndef MUKCA_TESTS_GEN3_H
#define MUKCA_TESTS_GEN3_H

#include <math.h>

#include "arms.h"

static void gen3_chain(mukca_chain *chain)
{
    static const double turn[8] = {1, 0.5, -0.5, 0.5, -0.5, 0.5, -0.5, 1}; /* times pi about x */
    static const double p[8][3] = {
        {0, 0, 0.1564},        {0, 0.0054, -0.1284}, {0, -0.2104, -0.0064}, {0, 0.0064, -0.2104},
        {0, -0.2084, -0.0064}, {0, 0, -0.1059},      {0, -0.1059, 0},       {0, 0, -0.0615}};
    make_chain(chain, "CRCRCRCF", NULL, "joint_", HUGE_VAL);
    chain->gravity[2] = -9.80665;
    for (int k = 0; k < 8; k++) {
        mukca_element *e = &chain->element[k];
        snprintf(e->child, sizeof e->child, k < 7 ? "link_%d" : "tip", k + 1);
        memcpy(e->xyz, p[k], sizeof e->xyz);
        e->rpy[0] = turn[k] * 3.14159265358979323846;
        if (k % 2 && k < 7) e->upper = k == 1 ? 2.41 : k == 3 ? 2.66 : 2.23, e->lower = -e->upper;
    }
}

/* Table 3, model 1. */
static const double gen3_dq[7] = {0.0044, 0.0088, -0.0035, -0.0043, 0.0068, 0.0026, -0.0084};
static const double gen3_dp[8][3] = {{0.0085, 0.0003, -0.0083},
                                     {-0.0068, 0, 0},
                                     {-0.0001, -0.0041, 0.0028},
                                     {-0.0003, 0.0015, 0},
                                     {0.0001, 0, 0},
                                     {-0.0003, -0.0001, -0.0024},
                                     {0.0009, 0, 0},
                                     {0.0009, -0.0003, 0}};

#endif
