/* Findings of a diagnosis: groups of causes of which one is sure, with sizes. */
#ifndef MUKCA_DIAGNOSE_FINDINGS_H
#define MUKCA_DIAGNOSE_FINDINGS_H

#include "diagnose/identify.h"
#include "infer/findings.h"

/* Positions are the joints' numbers, this, and n_joints: the tool. */
#define MUKCA_POSITION_BASE (-1)

/* Label of a candidate that is no outlier: the position of a function of an angle is the joint
 * whose angle it is, that of all others is where they act. */
mukca_label mukca_candidate_label(const mukca_candidate *candidate,
                                  const mukca_recording *recording, const mukca_unknowns *unknowns);

/* The findings from the sets of a search.  Errors: MUKCA_MEMORY. */
mukca_status mukca_findings_reach(mukca_diagnosis *d, mukca_search *id, mukca_error *error);

#endif
