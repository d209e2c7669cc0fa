/* What is confounded with what: causes and close candidates, after geometry is projected out. */
#ifndef MUKCA_DIAGNOSE_CONFOUNDING_H
#define MUKCA_DIAGNOSE_CONFOUNDING_H

#include "diagnose/competition.h"

/* Fill diagnosis->confounding from its causes and ties.  The contest's model still holds the
 * causes; afterwards its evidence is that of the whole model. */
void mukca_confounding_measure(mukca_diagnosis *diagnosis, mukca_competition *contest);

#endif
