/* Findings of a diagnosis: groups of causes of which one is sure, with sizes. */
#ifndef MUKCA_DIAGNOSE_FINDINGS_H
#define MUKCA_DIAGNOSE_FINDINGS_H

#include "diagnose/identify.h"
#include "diagnose/label.h"

/* Posterior of the last search with labels. */
typedef struct {
    mukca_labelled_sets posterior;
    int *label_of; /* [n_kept] of the candidates that were searched, -1: outlier */
} mukca_labelled_search;

/* Findings from the sets of the last search.  Errors: MUKCA_MEMORY. */
mukca_status mukca_findings_reach(mukca_diagnosis *d, mukca_search *id, mukca_error *error);

/* Sizes, coefficients and alternatives of all groups (finding_size.c).  Changes what the scan is
 * aimed at.  False: no memory. */
bool mukca_findings_measure(mukca_diagnosis *d, mukca_search *id, const mukca_labelled_search *in);

#endif
