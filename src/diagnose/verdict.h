/* What a competition found, told. */
#ifndef MUKCA_DIAGNOSE_VERDICT_H
#define MUKCA_DIAGNOSE_VERDICT_H

#include "diagnose/competition.h"

/* Fill causes, ties, verdict, where and what was tested of a diagnosis from the model as the
 * competition left it. */
void mukca_verdict_reach(mukca_diagnosis *diagnosis, mukca_competition *contest);

#endif
