/* The list of candidate causes for a recording, with their prior odds. */
#ifndef MUKCA_DIAGNOSE_CANDIDATES_H
#define MUKCA_DIAGNOSE_CANDIDATES_H

#include <math.h>

#include "diagnose/unknowns.h"
#include "effect/catalogue.h"

typedef struct {
    mukca_candidate *list;
    int count, capacity;
    int first_unlisted;          /* unlisted candidates come last */
    mukca_effect_survey survey;  /* of the recording */
    int classes;                 /* number of competing classes, with gear harmonics if scanned */
    bool enabled[MUKCA_CLASSES]; /* classes in the competition */
    bool harmonics;              /* ripple is listed, and further orders where they promise */
    const char *missing[MUKCA_CLASSES]; /* reason why a class has no candidate, or NULL */
} mukca_candidates;

enum {
    MUKCA_RIPPLE_LONG = 32, /* orders listed from the start: the geometry may absorb much of them */
    MUKCA_RIPPLE_MOST = 36  /* further orders of a joint */
};

/* Width of the bumps below which an unknown function resolves more than the orders of
 * MUKCA_RIPPLE_LONG, rad: half a period. */
#define MUKCA_FINE_WIDTH (M_PI / MUKCA_RIPPLE_LONG)

/* Least travel that shows a ripple, rad: half a turn of the finest order, 400. */
#define MUKCA_RIPPLE_TRAVEL 1e-2

/* Append an order of ripple of a joint that is not listed yet, if there is room.  Errors:
 * MUKCA_MEMORY. */
mukca_status mukca_candidates_add_ripple(mukca_candidates *all, mukca_pool *pool,
                                         const mukca_recording *recording, int joint, int order,
                                         mukca_error *error);

/* All candidates for a recording, except effects with disabled[effect] != 0 (NULL: none).  Memory
 * comes from `pool`.  Errors: MUKCA_MEMORY. */
mukca_status mukca_candidates_list(mukca_candidates *all, mukca_pool *pool,
                                   const mukca_recording *recording, const mukca_unknowns *unknowns,
                                   const unsigned char *disabled, mukca_error *error);

/* Only the elastic effects, without prior odds. */
mukca_status mukca_candidates_list_springs(mukca_candidates *all, mukca_pool *pool,
                                           const mukca_recording *recording,
                                           const unsigned char *disabled, mukca_error *error);

#endif
