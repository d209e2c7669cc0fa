/* The list of candidate causes for a recording, with their forward models and prior odds. */
#ifndef MUKCA_DIAGNOSE_CANDIDATES_H
#define MUKCA_DIAGNOSE_CANDIDATES_H

#include "diagnose/model.h"

/* Classes compete as equals: the catalogue's effects, then the two rivals of all of them. */
enum { GAP_CLASS_OUTLIER = MUKCA_EFFECT_COUNT, GAP_CLASS_UNKNOWN, GAP_CLASSES };

typedef struct {
    gap_hypothesis *list;
    int count, capacity;
    int classes;                      /* that compete, gear harmonics included where scanned */
    bool enabled[GAP_CLASSES];        /* classes in the competition */
    bool harmonics;                   /* gear harmonics are scanned beside the list */
    const char *missing[GAP_CLASSES]; /* why a class could not be listed at all, NULL otherwise */
} gap_hypotheses;

/* Class of a hypothesis. */
int gap_hypothesis_class(const gap_hypothesis *h);

/* Was it fitted with one factor per mass: the first term is all masses, the others one each? */
bool gap_hypothesis_by_mass(const gap_hypothesis *h);

/* All candidates for the model's recording, except effects with disabled[effect] != 0 (NULL: none).
 * Memory comes from `pool`.  Errors: MUKCA_MEMORY. */
mukca_status gap_hypotheses_list(gap_hypotheses *all, mukca_pool *pool, const gap_model *m,
                                 const unsigned char *disabled, mukca_error *error);

/* Fill basis and units of one hypothesis whose effect is set (used for harmonics that the scan
 * found).  Returns false when memory failed. */
bool gap_hypothesis_prepare(gap_hypothesis *h, mukca_pool *pool, const gap_model *m);

#endif
