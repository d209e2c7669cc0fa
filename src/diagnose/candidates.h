/* The list of candidate causes for a recording, with their prior odds. */
#ifndef MUKCA_DIAGNOSE_CANDIDATES_H
#define MUKCA_DIAGNOSE_CANDIDATES_H

#include "diagnose/unknowns.h"
#include "effect/catalogue.h"

typedef struct {
    mukca_candidate *list;
    int count, capacity;
    mukca_pool *pool; /* of the list; check `failed` */
    const mukca_recording *recording;
    const unsigned char *disabled; /* [MUKCA_EFFECT_COUNT] excluded effects, or NULL */
    mukca_effect_survey survey;    /* of the recording */
    int classes;                   /* number of competing classes */
    bool enabled[MUKCA_CLASSES];   /* classes in the competition */
} mukca_candidates;

/* Begin with the effects of the catalogue.  Memory comes from `pool`; recording and disabled must
 * outlive them. */
void mukca_candidates_start(mukca_candidates *all, mukca_pool *pool,
                            const mukca_recording *recording, const unsigned char *disabled);

/* Append a candidate, unless its effect is disabled. */
void mukca_candidates_append(mukca_candidates *all, mukca_candidate candidate);

/* Append the recording faults (candidate_faults.c); the causes outside the catalogue
 * (candidate_unlisted.c). */
void mukca_candidates_append_faults(mukca_candidates *all);
void mukca_candidates_append_unlisted(mukca_candidates *all, const mukca_unknowns *unknowns);

/* Drop, after their computation, the causes outside the catalogue that are an effect in the list.
 */
void mukca_candidates_drop_listed(mukca_candidates *all);

/* Compute the functions and units of all candidates; or (taken[count] not NULL) anew the functions
 * of those marked, and of those with which they share them, which are marked, too. */
void mukca_candidates_fill(const mukca_candidates *all, unsigned char *taken);

/* After the start: all candidates for a recording, with prior odds.  Errors: MUKCA_MEMORY. */
mukca_status mukca_candidates_list(mukca_candidates *all, const mukca_unknowns *unknowns,
                                   mukca_error *error);

/* Log prior odds of an order of a periodic candidate: an effect of the trait MUKCA_TRAIT_ORDERS, or
 * a listed wave of order 1 outside the catalogue, of which all octaves are equally probable. */
double mukca_candidates_order_prior(const mukca_candidates *all, const mukca_candidate *candidate,
                                    int order);

/* Append such a candidate, with an order that is not listed yet, if there is room.  Errors:
 * MUKCA_MEMORY. */
mukca_status mukca_candidates_add_order(mukca_candidates *all, mukca_candidate candidate, int order,
                                        mukca_error *error);

#endif
