/* Confounding of causes and close candidates: canonical correlations with the geometry projected
 * out. */
#ifndef MUKCA_DIAGNOSE_CONFOUNDING_H
#define MUKCA_DIAGNOSE_CONFOUNDING_H

#include "diagnose/verdict.h"

/* Fill `out` for the causes and ties of the findings.  The competition's regression must contain
 * the causes; at return its evidence is that of the whole model. */
void mukca_confounding_measure(mukca_confounding *out, const mukca_findings *findings,
                               mukca_identification *id);

#endif
