/* The list of candidate causes for a recording, with their prior odds. */
#ifndef MUKCA_DIAGNOSE_CANDIDATES_H
#define MUKCA_DIAGNOSE_CANDIDATES_H

#include "diagnose/unknowns.h"
#include "effect/catalogue.h"

typedef struct {
    mukca_candidate *list;
    int count, capacity;
    int first_unlisted;                 /* unlisted candidates come last */
    mukca_effect_survey survey;         /* of the recording */
    int classes;                        /* number of competing classes */
    bool enabled[MUKCA_CLASSES];        /* classes in the competition */
    const char *missing[MUKCA_CLASSES]; /* reason why a class has no candidate, or NULL */
} mukca_candidates;

/* Append an effect of the trait MUKCA_TRAIT_ORDERS, if there is room: an order that is not listed
 * yet.  Errors: MUKCA_MEMORY. */
mukca_status mukca_candidates_add_order(mukca_candidates *all, mukca_pool *pool,
                                        const mukca_recording *recording,
                                        const mukca_effect *effect, mukca_error *error);

/* All candidates for a recording, except effects with disabled[effect] != 0 (NULL: none).  Memory
 * comes from `pool`.  Errors: MUKCA_MEMORY. */
mukca_status mukca_candidates_list(mukca_candidates *all, mukca_pool *pool,
                                   const mukca_recording *recording, const mukca_unknowns *unknowns,
                                   const unsigned char *disabled, mukca_error *error);

/* Only the effects of the catalogue, without prior odds. */
mukca_status mukca_candidates_list_effects(mukca_candidates *all, mukca_pool *pool,
                                           const mukca_recording *recording,
                                           const unsigned char *disabled, mukca_error *error);

#endif
