/* Identification: posterior probability of sets of causes of the remaining error. */
#ifndef MUKCA_DIAGNOSE_IDENTIFY_H
#define MUKCA_DIAGNOSE_IDENTIFY_H

#include "diagnose/diagnose.h"
#include "diagnose/scan.h"
#include "diagnose/screening.h"

/* A set of candidates. */
typedef struct {
    int n;
    int candidate[MUKCA_SET_ITEMS]; /* of the list */
    double scale[MUKCA_SET_ITEMS];  /* most probable prior sizes */
    double weight;                  /* posterior probability */
    int index;                      /* of the last search's sets */
} mukca_causes;

enum { MUKCA_PASSES = 6 };

typedef struct {
    mukca_regression *m;
    mukca_diagnosis *diagnosis; /* its faults are from screening; their rows may be reinstated */
    const mukca_diagnose_options *options;
    mukca_candidates all;
    mukca_scan scan;
    int n_sets;
    mukca_causes *set; /* [n_sets] by falling weight */
    /* the last search, under the most probable family of the noise */
    int n_kept, *kept; /* its items are these candidates */
    mukca_question question;
    mukca_sets sets;
    bool listed;   /* without causes outside the catalogue */
    double *tails; /* [n_rows] of Student's noise, if this is more probable */
    bool settled;  /* the set of its linearisation was among the best, or passes alternate */
    int n_passed;
    mukca_causes passed[MUKCA_PASSES]; /* sets of the linearisations */
    mukca_ranked *ranked;              /* scratch */
    unsigned char *taken;
    mukca_pool pool, search_pool; /* of all; of the last search */
} mukca_search;

/* List the candidates and find the most probable sets of them, with Gaussian noise.  Errors:
 * MUKCA_MEMORY, MUKCA_INTERRUPTED. */
mukca_status mukca_identify_run(mukca_search *search, mukca_error *error);

/* The same with Student's noise search->tails, not NULL, from the empty set.  Errors: as above. */
mukca_status mukca_identify_with_tails(mukca_search *search, mukca_error *error);

/* The same among the candidates kept that are in the catalogue, from those of the best set; from
 * then on no others are kept.  Errors: as above. */
mukca_status mukca_identify_listed(mukca_search *search, mukca_error *error);

/* Fit the regression to the most probable set, by least squares.  Before, the last search can be
 * continued. */
void mukca_identify_settle(mukca_search *search);
void mukca_identify_free(mukca_search *search);

/* Fit the regression to a set. */
void mukca_identify_fit(mukca_search *search, const mukca_causes *set);

#endif
