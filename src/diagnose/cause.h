/* Description of an identified cause, the verdict on all, and what was tested. */
#ifndef MUKCA_DIAGNOSE_CAUSE_H
#define MUKCA_DIAGNOSE_CAUSE_H

#include "diagnose/identify.h"

/* The thresholds of a diagnosis: a cause more probable than not is listed; one with less doubt
 * than this is stated without reserve, and a rival with more is named. */
#define MUKCA_LISTED 0.5
#define MUKCA_DOUBT 0.05
/* Least probability of a suspected cause. */
#define MUKCA_SUSPECTED 0.2

/* Log Bayes factor of a member of a set given its other members; -HUGE_VAL: not in the last search.
 */
double mukca_cause_gain(mukca_search *search, const mukca_causes *set, int member);

/* Has a set a member of a group? */
bool mukca_cause_is_in(const mukca_search *search, const mukca_causes *set,
                       const mukca_finding_group *group);

/* Describe a member of the set to which the regression is fitted; needs its factor. */
void mukca_cause_describe(mukca_cause *cause, mukca_search *search, const mukca_causes *best,
                          int member);

/* Part of the explained that findings of one effect at one joint must have for `named`, and of the
 * largest finding's probability that must lie outside the catalogue for `unknown`. */
#define MUKCA_VERDICT_HALF 0.5

/* Probability of the sets with a member of a class, or (-1) with any but outliers. */
double mukca_verdict_probability(const mukca_search *search, int class);

/* The verdict: what makes up half of the explained part.  Without a finding, structure that is sure
 * has no place.  any, outside: probability of the sets with any cause, and with one outside the
 * catalogue. */
mukca_verdict mukca_verdict_of(const mukca_diagnosis *d, double any, double outside);

/* Causes, ties, verdict, location and faults.  The regression is left fitted to a set with all
 * listed causes. */
void mukca_verdict_reach(mukca_diagnosis *d, mukca_search *search);

/* Fit the regression to what is applied, a mean over sets of which each has some of the causes: of
 * the last search, the members of the findings and the other named causes; or, if this predicts
 * held-out samples better, all causes of a search among those of the catalogue.  Faults stay as
 * they are.  Errors: MUKCA_MEMORY, MUKCA_INTERRUPTED. */
mukca_status mukca_averaged_fit(mukca_regression *m, mukca_search *search, mukca_error *error);

/* List every effect and joint: candidates with their scores of the scan, the others with the reason
 * why they are not testable. */
void mukca_untested_list(mukca_diagnosis *d, const mukca_scan *scan);

/* List all effects as not testable, for this reason. */
void mukca_untested_all(mukca_diagnosis *d, const char *why);

#endif
