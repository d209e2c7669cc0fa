/* A chain of two revolute joints, j1 and j2. */
#ifndef MUKCA_FUZZ_TWO_JOINTS_H
#define MUKCA_FUZZ_TWO_JOINTS_H

#include <stdio.h>

#include "mukca/chain.h"

static inline const mukca_chain *two_joints(void)
{
    static mukca_chain chain;
    chain.n_elements = chain.n_joints = 2;
    for (int j = 0; j < 2; j++) {
        mukca_element *e = &chain.element[j];
        snprintf(e->name, sizeof e->name, "j%d", j + 1);
        e->type = MUKCA_REVOLUTE;
        e->joint = chain.joint_element[j] = j;
        e->axis[2] = 1;
        e->upper = 3;
    }
    return &chain;
}

#endif
