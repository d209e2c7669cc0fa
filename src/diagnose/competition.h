/* Competition of all candidate causes: forward steps, swaps, and the odds of those outside. */
#ifndef MUKCA_DIAGNOSE_COMPETITION_H
#define MUKCA_DIAGNOSE_COMPETITION_H

#include "diagnose/diagnose.h"
#include "diagnose/heavy_tails.h"
#include "diagnose/scan.h"
#include "diagnose/screening.h"

/* Candidates that a report would call the same: one effect at one joint (with its placement, socket
 * or row), all variants together. */
typedef struct {
    int class, joint, place; /* place: placement, group or row; -1 */
    double log_odds;         /* of all members together */
    int best;                /* score of its best member */
} mukca_contender;

/* State to which a search can return. */
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
    mukca_faults *faults; /* from screening; their rows may be reinstated */
    const mukca_diagnose_options *options;
    mukca_contender *table; /* [scores], by falling odds after mukca_competition_rank */
    int n_table;
    mukca_contender *first; /* the same after the first scan: evidence for each candidate alone */
    int n_first;
    mukca_score *first_score;
    /* [scores]: 1 excluded, its score is due to noise in the angles; -1 tested and kept; 0 not
     * tested yet */
    signed char *noise_made;
    double *waiting; /* [scores] log odds of candidates outside the final model, given its causes */
    mukca_heavy_tails tails;
    mukca_unknowns kept;         /* unknowns before the last change */
    mukca_search_state parting;  /* before the first step with `parted` */
    mukca_search_state unsprung; /* before the first step with `sprung`, else start of the search */
    bool left_unlisted;          /* `waiting` includes the unlisted causes */
    bool scanned;                /* the last run against the whole model was of the present set */
    bool names_first; /* an unknown function is accepted only if no named candidate passes */
    bool passed_over; /* an unknown function led on the way by more than the preference */
    bool parted;      /* a named candidate was accepted before an unknown function that led */
    bool sprung;      /* an elastic cause was accepted, with names_first */
} mukca_competition;

/* Is it an elastic effect? */
bool mukca_competition_is_spring(const mukca_candidate *candidate);

/* Save the state of the search. */
void mukca_competition_save(mukca_search_state *state, const mukca_competition *contest);

/* Group the last scan's scores into contenders, best first. */
void mukca_competition_rank(mukca_competition *contest);

/* Is the contender's best member in the model already, as a cause other than `except`?  It scores
 * again if its prior is too narrow for the data. */
bool mukca_competition_taken(const mukca_competition *contest, const mukca_contender *candidate,
                             int except);

/* Forward steps, then swaps, from the present model; with names_first unknown functions are
 * accepted only if no named candidate passes.  Errors: MUKCA_INTERRUPTED. */
mukca_status mukca_competition_search(mukca_competition *contest, bool names_first,
                                      mukca_error *error);

/* Store the odds of candidates above the threshold that stay outside, for lack of room or because
 * heavy-tailed noise explains them.  Later ranks subtract them: these odds do not make a candidate
 * the rival of an accepted cause. */
void mukca_competition_leave_waiting(mukca_competition *contest);

/* The same for unlisted causes, which are never accepted: given the final model.  False: done
 * before. */
bool mukca_competition_leave_unlisted(mukca_competition *contest);

/* The swaps alone.  Errors: MUKCA_INTERRUPTED. */
mukca_status mukca_competition_settle(mukca_competition *contest, mukca_error *error);

#endif
