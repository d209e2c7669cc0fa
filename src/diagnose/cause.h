/* Description of an accepted cause: size, probability and rivals. */
#ifndef MUKCA_DIAGNOSE_CAUSE_H
#define MUKCA_DIAGNOSE_CAUSE_H

#include "diagnose/competition.h"

/* Comparison of a cause with all candidates in the model without it. */
typedef struct {
    double log_odds; /* against no cause; -HUGE_VAL: an outlier, or not among the candidates */
    double unknown;  /* probability of an unknown function instead ... */
    double by_joint[MUKCA_MAX_JOINTS]; /* ... and of one that acts on each joint */
} mukca_standing;

/* Least probability of an unknown function that is reported as a rival of a cause. */
#define MUKCA_UNKNOWN_SHARE 0.25

/* Log odds that separate two causes of nearly the same effect: 400 to 1. */
#define MUKCA_TIE_MOST 6.0

/* Compare accepted cause `index` of the competition with all candidates, and describe it if it is
 * an effect of the catalogue; returns false otherwise, and `cause` (may be NULL) is not set.
 * mukca_cause_measure() adds the amplitude. */
bool mukca_cause_describe(mukca_cause *cause, mukca_standing *standing,
                          mukca_competition *competition, int index);

/* Reserve a share of a described cause's probability for causes outside the catalogue. */
void mukca_cause_doubt(mukca_cause *cause);

/* Index of the accepted cause of a description; -1: none. */
int mukca_cause_find(const mukca_regression *m, const mukca_cause *cause);

/* Size of a described cause and its 95 % interval; needs the factor of the full model. */
void mukca_cause_measure(mukca_cause *cause, mukca_regression *m, int index);

#endif
