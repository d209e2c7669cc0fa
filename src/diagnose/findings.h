/* Findings of a diagnosis: what candidates say, groups of these of which one is sure, and sizes. */
#ifndef MUKCA_DIAGNOSE_FINDINGS_H
#define MUKCA_DIAGNOSE_FINDINGS_H

#include "diagnose/identify.h"

/* Positions are the joints' numbers, this, and n_joints: the tool. */
#define MUKCA_POSITION_BASE (-1)

/* Label of a candidate that is no outlier: what the error varies with, which effect, and where; the
 * position of a function of an angle is the joint whose angle it is, that of all others is where
 * they act (label.c). */
mukca_label mukca_candidate_label(const mukca_candidate *candidate,
                                  const mukca_recording *recording, const mukca_unknowns *unknowns);

/* Posterior of the last search with labels. */
typedef struct {
    mukca_labelled_sets posterior;
    int *label_of; /* [n_kept] of the candidates that were searched, -1: outlier */
} mukca_labelled_search;

/* Findings from the sets of the last search.  Errors: MUKCA_MEMORY. */
mukca_status mukca_findings_reach(mukca_diagnosis *d, mukca_search *search, mukca_error *error);

/* Sizes, coefficients and alternatives of all groups (finding_size.c).  Changes what the scan is
 * aimed at.  Scratch comes from `pool`.  False: no memory. */
bool mukca_findings_measure(mukca_diagnosis *d, mukca_pool *pool, mukca_search *search,
                            const mukca_labelled_search *in);

#endif
