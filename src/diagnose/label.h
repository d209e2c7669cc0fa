/* What a candidate says: what the error varies with, which effect, and where. */
#ifndef MUKCA_DIAGNOSE_LABEL_H
#define MUKCA_DIAGNOSE_LABEL_H

#include "diagnose/unknowns.h"
#include "infer/findings.h"

/* Positions are the joints' numbers, this, and n_joints: the tool. */
#define MUKCA_POSITION_BASE (-1)

/* Label of a candidate that is no outlier: the position of a function of an angle is the joint
 * whose angle it is, that of all others is where they act. */
mukca_label mukca_candidate_label(const mukca_candidate *candidate,
                                  const mukca_recording *recording, const mukca_unknowns *unknowns);

#endif
