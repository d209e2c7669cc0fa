/* Posterior over sets of causes in halves of the postures. */
#ifndef MUKCA_DIAGNOSE_HALVES_H
#define MUKCA_DIAGNOSE_HALVES_H

#include "diagnose/identify.h"

/* The search in one half, which has the candidates of the last search that matter there. */
typedef struct {
    mukca_question question;
    mukca_sets sets;
} mukca_half;

typedef struct {
    int n;                 /* MUKCA_HALVES: 2 h and 2 h + 1 are complements, without sets if one has
                              too few postures, or is singular; 0: all are so */
    int n_items, *item_of; /* [n_items] item of the last search */
    mukca_item *item;
    mukca_half half[MUKCA_HALVES];
    mukca_pool pool[MUKCA_MOST_WORKERS]; /* of the halves that each worker searched */
} mukca_halves;

/* Search the halves.  They share linearisation, candidates and whitened columns with the whole; the
 * geometry is integrated out in each.  The items' memory comes from `pool`, the rest is to be
 * freed, whatever is returned.  Errors: MUKCA_MEMORY. */
mukca_status mukca_halves_search(mukca_halves *halves, mukca_pool *pool, mukca_search *search,
                                 mukca_error *error);
void mukca_halves_free(mukca_halves *halves);

#endif
