/* Tested effects, detection limits, and effects that are not testable. */
#ifndef MUKCA_DIAGNOSE_UNTESTED_H
#define MUKCA_DIAGNOSE_UNTESTED_H

#include "diagnose/identify.h"

typedef struct {
    int count;
    mukca_tested list[MUKCA_MAX_TESTED];
} mukca_tested_list;

/* List every effect and joint: candidates with their scores of the first scan, the others with the
 * reason. */
void mukca_untested_list(mukca_tested_list *tested, const mukca_identification *id);

/* List all effects as not testable, for this reason. */
void mukca_untested_all(mukca_tested_list *tested, const char *why);

#endif
