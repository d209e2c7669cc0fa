/* The list of candidate causes for a recording, with their prior odds. */
#ifndef MUKCA_DIAGNOSE_CANDIDATES_H
#define MUKCA_DIAGNOSE_CANDIDATES_H

#include "diagnose/unknowns.h"
#include "effect/survey.h"

typedef struct {
    mukca_candidate *list;
    int count, capacity;
    int first_unlisted;                 /* the candidates from there on are unlisted */
    mukca_effect_survey survey;         /* of the recording */
    int classes;                        /* that compete, gear harmonics included where scanned */
    bool enabled[MUKCA_CLASSES];        /* classes in the competition */
    bool harmonics;                     /* all orders of gear ripple are scanned, too */
    const char *missing[MUKCA_CLASSES]; /* why a class could not be listed at all, or NULL */
} mukca_candidates;

/* All candidates for a recording, except effects with disabled[effect] != 0 (NULL: none).  The
 * unlisted ones are not prepared yet.  Memory comes from `pool`.  Errors: MUKCA_MEMORY. */
mukca_status mukca_candidates_list(mukca_candidates *all, mukca_pool *pool,
                                   const mukca_recording *recording, const mukca_unknowns *unknowns,
                                   const unsigned char *disabled, mukca_error *error);

/* The elastic effects alone, without prior odds. */
mukca_status mukca_candidates_list_springs(mukca_candidates *all, mukca_pool *pool,
                                           const mukca_recording *recording,
                                           const unsigned char *disabled, mukca_error *error);

#endif
