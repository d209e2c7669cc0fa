/* The verdict on the identified sets of causes. */
#ifndef MUKCA_DIAGNOSE_VERDICT_H
#define MUKCA_DIAGNOSE_VERDICT_H

#include "diagnose/identify.h"

typedef struct {
    mukca_verdict verdict;
    bool unexplained;
    double structure; /* largest log Bayes factor of an unknown function; -HUGE_VAL: none */
    int n_causes, n_where;
    mukca_cause causes[MUKCA_MAX_CAUSES]; /* by descending evidence; also suspected ones */
    mukca_where where[MUKCA_MAX_JOINTS];  /* by descending share */
    int n_sets;
    mukca_cause_set sets[MUKCA_MAX_SETS];
} mukca_findings;

/* Causes, ties, verdict and location.  The regression is left fitted to a set with all listed
 * causes.  Outliers and moved tools are appended to `faults`. */
void mukca_verdict_reach(mukca_findings *findings, mukca_faults *faults, mukca_identification *id);

#endif
