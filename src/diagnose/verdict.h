/* The verdict on the identified sets of causes, and what was tested. */
#ifndef MUKCA_DIAGNOSE_VERDICT_H
#define MUKCA_DIAGNOSE_VERDICT_H

#include "diagnose/identify.h"

/* Causes, ties, verdict, location and faults.  The regression is left fitted to a set with all
 * listed causes. */
void mukca_verdict_reach(mukca_diagnosis *d, mukca_identification *id);

/* List every effect and joint: candidates with their scores of the first scan, the others with the
 * reason why they are not testable. */
void mukca_untested_list(mukca_diagnosis *d, const mukca_identification *id);

/* List all effects as not testable, for this reason. */
void mukca_untested_all(mukca_diagnosis *d, const char *why);

#endif
