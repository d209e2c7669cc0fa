/* The verdict on what a competition found. */
#ifndef MUKCA_DIAGNOSE_VERDICT_H
#define MUKCA_DIAGNOSE_VERDICT_H

#include "diagnose/competition.h"

typedef struct {
    mukca_verdict verdict;
    bool unexplained;
    int n_causes, n_where;
    mukca_cause causes[MUKCA_MAX_CAUSES]; /* by falling odds */
    mukca_where where[MUKCA_MAX_JOINTS];  /* by falling share */
} mukca_findings;

/* Causes, ties, verdict and place of what the competition left in its regression.  Outliers and
 * moved tools are appended to `faults`. */
void mukca_verdict_reach(mukca_findings *findings, mukca_faults *faults,
                         mukca_competition *competition);

#endif
