/* What was tested, the detection limits, and what cannot be tested. */
#ifndef MUKCA_DIAGNOSE_UNTESTED_H
#define MUKCA_DIAGNOSE_UNTESTED_H

#include "diagnose/competition.h"

typedef struct {
    int count;
    mukca_tested list[MUKCA_MAX_TESTED];
} mukca_tested_list;

/* Every effect and joint: those with a candidate as the first scan scored them, the others with
 * what is missing. */
void mukca_untested_list(mukca_tested_list *tested, const mukca_competition *competition);

/* No effect can be tested, for that reason. */
void mukca_untested_all(mukca_tested_list *tested, const char *why);

#endif
