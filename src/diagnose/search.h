/* Search for the most probable set of causes, from several starts. */
#ifndef MUKCA_DIAGNOSE_SEARCH_H
#define MUKCA_DIAGNOSE_SEARCH_H

#include "diagnose/competition.h"

/* Run the competition on a screened, fitted model; the causes are in contest->m.  Errors:
 * MUKCA_INTERRUPTED, MUKCA_MEMORY. */
mukca_status mukca_search_run(mukca_competition *contest, mukca_error *error);

#endif
