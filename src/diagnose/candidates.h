/* The list of candidate causes for a recording, with their prior odds. */
#ifndef MUKCA_DIAGNOSE_CANDIDATES_H
#define MUKCA_DIAGNOSE_CANDIDATES_H

#include "diagnose/unknowns.h"
#include "effect/survey.h"

typedef struct {
    mukca_candidate *list;
    int count, capacity;
    int first_unlisted;          /* unlisted candidates come last */
    mukca_effect_survey survey;  /* of the recording */
    int classes;                 /* number of competing classes, with gear harmonics if scanned */
    bool enabled[MUKCA_CLASSES]; /* classes in the competition */
    bool harmonics;              /* all orders of gear ripple are scanned, too */
    const char *missing[MUKCA_CLASSES]; /* reason why a class has no candidate, or NULL */
} mukca_candidates;

/* All candidates for a recording, except effects with disabled[effect] != 0 (NULL: none).  Unlisted
 * ones are not yet prepared.  Memory comes from `pool`.  Errors: MUKCA_MEMORY. */
mukca_status mukca_candidates_list(mukca_candidates *all, mukca_pool *pool,
                                   const mukca_recording *recording, const mukca_unknowns *unknowns,
                                   const unsigned char *disabled, mukca_error *error);

/* Only the elastic effects, without prior odds. */
mukca_status mukca_candidates_list_springs(mukca_candidates *all, mukca_pool *pool,
                                           const mukca_recording *recording,
                                           const unsigned char *disabled, mukca_error *error);

#endif
