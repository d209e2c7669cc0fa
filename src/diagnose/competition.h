/* The competition of all candidate causes: forward steps, swaps, and what remains of each. */
#ifndef MUKCA_DIAGNOSE_COMPETITION_H
#define MUKCA_DIAGNOSE_COMPETITION_H

#include "diagnose/diagnose.h"
#include "diagnose/scan.h"

/* Candidates that people would call the same thing: one effect at one joint (one placement, socket
 * or row where these belong to it), all variants together. */
typedef struct {
    int class, joint, place; /* place: placement, group or row; -1 */
    double log_odds;         /* of the group */
    int best;                /* score of its best member */
} gap_candidate;

typedef struct {
    gap_model *m;
    gap_hypotheses *all;
    gap_scan *scan;
    mukca_diagnosis *diagnosis;
    const mukca_diagnose_options *options;
    gap_candidate *table; /* [scores], by falling odds after gap_compete_rank */
    int n_table;
    gap_candidate *first; /* the same after the first scan: what each candidate is worth alone */
    int n_first;
    gap_score *first_score;
} gap_contest;

/* Collapse the last scan into candidates, best first. */
void gap_compete_rank(gap_contest *contest);

/* Is the candidate's best member in the model already, as another cause than `except`?  It comes up
 * again where its prior is too narrow for what the rows say. */
bool gap_compete_taken(const gap_contest *contest, const gap_candidate *candidate, int except);

/* Run the competition on a screened, fitted model; causes end in contest->m.  Errors:
 * MUKCA_INTERRUPTED. */
mukca_status gap_compete(gap_contest *contest, mukca_error *error);

#endif
