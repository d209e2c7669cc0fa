/* The competition of all candidate causes: forward steps, swaps, and what remains of each. */
#ifndef MUKCA_DIAGNOSE_COMPETITION_H
#define MUKCA_DIAGNOSE_COMPETITION_H

#include "diagnose/diagnose.h"
#include "diagnose/heavy_tails.h"
#include "diagnose/scan.h"
#include "diagnose/screening.h"

/* Candidates that people would call the same thing: one effect at one joint (one placement, socket
 * or row where these belong to it), all variants together. */
typedef struct {
    int class, joint, place; /* place: placement, group or row; -1 */
    double log_odds;         /* of the group */
    int best;                /* score of its best member */
} mukca_contender;

/* Where a search can go back to. */
typedef struct {
    mukca_unknowns unknowns;
    unsigned char *keep; /* [n_rows] of the recording */
    mukca_faults *faults;
    int steps; /* of the scan */
} mukca_search_state;

typedef struct {
    mukca_regression *m;
    mukca_candidates *all;
    mukca_scan *scan;
    mukca_faults *faults; /* rows cut before may come back */
    const mukca_diagnose_options *options;
    mukca_contender *table; /* [scores], by falling odds after mukca_competition_rank */
    int n_table;
    mukca_contender *first; /* the same after the first scan: what each candidate is worth alone */
    int n_first;
    mukca_score *first_score;
    /* [scores]: 1 excluded, since the noise in the angles makes its score; -1 tested and kept; 0
     * not tested yet */
    signed char *noise_made;
    double *waiting; /* [scores] log odds beside the accepted causes of what stays outside */
    mukca_heavy_tails tails;
    mukca_unknowns kept;         /* to go back to */
    mukca_search_state parting;  /* before the first step where `parted` */
    mukca_search_state unsprung; /* before the first step where `sprung`; before: where the search
                                    began */
    bool left_unlisted; /* what unlisted causes are worth beside the accepted ones is in waiting */
    bool scanned;       /* the last run against a whole set was of the present one */
    bool names_first;   /* an unknown function comes when no name passes */
    bool passed_over;   /* ... and one led by more on the way */
    bool parted;        /* a name came before an unknown function that led */
    bool sprung;        /* an elastic cause was accepted, with names first */
} mukca_competition;

/* Is it an elastic effect? */
bool mukca_competition_is_spring(const mukca_candidate *candidate);

/* Keep the state of the search. */
void mukca_competition_save(mukca_search_state *state, const mukca_competition *contest);

/* Collapse the last scan into candidates, best first. */
void mukca_competition_rank(mukca_competition *contest);

/* Is the candidate's best member in the model already, as another cause than `except`?  It comes up
 * again where its prior is too narrow for what the rows say. */
bool mukca_competition_taken(const mukca_competition *contest, const mukca_contender *candidate,
                             int except);

/* Forward steps, then swaps, from the present model on; with names_first an unknown function waits
 * until no name passes.  Errors: MUKCA_INTERRUPTED. */
mukca_status mukca_competition_search(mukca_competition *contest, bool names_first,
                                      mukca_error *error);

/* Where no room is left, or only noise with heavy tails makes them, candidates that reach the
 * threshold stay outside.  They are no rivals of an accepted cause by what they are worth beside
 * it: the ranks after this are without that. */
void mukca_competition_leave_waiting(mukca_competition *contest);

/* The same for causes that nobody listed, which are never accepted: beside the final model.  False:
 * done before. */
bool mukca_competition_leave_unlisted(mukca_competition *contest);

/* The swaps alone.  Errors: MUKCA_INTERRUPTED. */
mukca_status mukca_competition_settle(mukca_competition *contest, mukca_error *error);

#endif
