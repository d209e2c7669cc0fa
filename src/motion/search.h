/* Posterior over sets of effects, in the whole recording and in its halves. */
#ifndef MUKCA_MOTION_SEARCH_H
#define MUKCA_MOTION_SEARCH_H

#include "motion/torques.h"

enum { MUKCA_TORQUE_SETS = 100 }; /* sets that are averaged */

typedef struct {
    mukca_torques *t;
    mukca_pool pool;    /* of the last pass */
    mukca_pool columns; /* of t->items */
    bool loads;         /* the best set has friction under load: that of t->point */
    int n_kept, *kept;  /* items of the last pass, ascending */
    mukca_question question;
    mukca_sets sets;
    int n_sets, set[MUKCA_TORQUE_SETS]; /* most probable ones of `sets`, by falling weight */
    double weight[MUKCA_TORQUE_SETS];
} mukca_torque_search;

/* Search, with the noise and the point of linearisation of the best set.  Errors: MUKCA_MEMORY,
 * MUKCA_UNIDENTIFIABLE. */
mukca_status mukca_torque_search_run(mukca_torque_search *search, mukca_pool *pool,
                                     mukca_error *error);
void mukca_torque_search_free(mukca_torque_search *search);

/* Search the same items, from nothing, in one of MUKCA_HALVES halves of the blocks. False: no
 * memory. */
bool mukca_torque_search_half(mukca_torque_search *half, const mukca_torque_search *whole,
                              int number);

#endif
