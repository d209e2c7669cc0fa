/* The verdict on the causes accepted in a competition. */
#ifndef MUKCA_DIAGNOSE_VERDICT_H
#define MUKCA_DIAGNOSE_VERDICT_H

#include "diagnose/competition.h"

typedef struct {
    mukca_verdict verdict;
    bool unexplained;
    int n_causes, n_where;
    mukca_cause causes[MUKCA_MAX_CAUSES]; /* by descending odds */
    mukca_where where[MUKCA_MAX_JOINTS];  /* by descending share */
} mukca_findings;

/* Causes, ties, verdict and location, from the competition's final regression.  Outliers and moved
 * tools are appended to `faults`. */
void mukca_verdict_reach(mukca_findings *findings, mukca_faults *faults,
                         mukca_competition *competition);

#endif
