/* Is the arm mounted as the model says?  Gravity in another direction of the base frame. */
#ifndef MUKCA_DIAGNOSE_MOUNTING_H
#define MUKCA_DIAGNOSE_MOUNTING_H

#include "diagnose/diagnose.h"

/* Where elasticity under the gravity of `chain` does not explain a recording, diagnose it with
 * gravity along the other axes of the base frame.  If elastic causes under one of them explain it
 * far better, the diagnosis gets that gravity, and its causes are no longer certain: an effect
 * outside the catalogue would do as well.  Costs four fits of the geometry with all springs, and a
 * diagnosis without held-out errors for each direction that they speak for.  `options` are those of
 * the diagnosis.  Errors: as of mukca_diagnose. */
mukca_status mukca_mounting_compare(mukca_diagnosis *diagnosis, const mukca_chain *chain,
                                    const mukca_dataset *data,
                                    const mukca_diagnose_options *options, mukca_error *error);

#endif
