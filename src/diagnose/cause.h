/* One accepted cause, described: its size, how probable it is, and what else it could be. */
#ifndef MUKCA_DIAGNOSE_CAUSE_H
#define MUKCA_DIAGNOSE_CAUSE_H

#include "diagnose/competition.h"

/* What the other candidates make of a cause once it is left out. */
typedef struct {
    double log_odds; /* of the cause against nothing; -HUGE_VAL: an outlier, or none */
    double unknown;  /* probability of an unknown function instead ... */
    double by_joint[MUKCA_MAX_JOINTS]; /* ... and of one that acts on each joint */
} mukca_standing;

/* Probability from which a function that no effect makes is reported as a rival of a cause. */
#define MUKCA_UNKNOWN_SHARE 0.25

/* Log odds that part two causes that do nearly the same: 400 to 1. */
#define MUKCA_TIE_MOST 6.0

/* Test accepted cause `index` of the competition against all others, and describe it where it has a
 * name: returns false otherwise, and `cause` (may be NULL) is not set.  Amplitudes follow by
 * mukca_cause_measure. */
bool mukca_cause_describe(mukca_cause *cause, mukca_standing *standing,
                          mukca_competition *competition, int index);

/* Let a described cause share its probability with what is outside the catalogue. */
void mukca_cause_doubt(mukca_cause *cause);

/* The accepted cause behind a described one, -1: none. */
int mukca_cause_find(const mukca_regression *m, const mukca_cause *cause);

/* Size of a described cause and its 95 % interval; needs the factor of the full model. */
void mukca_cause_measure(mukca_cause *cause, mukca_regression *m, int index);

#endif
