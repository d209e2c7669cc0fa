/* Is the arm mounted as the model says?  Gravity in another direction of the base frame. */
#ifndef MUKCA_DIAGNOSE_MOUNTING_H
#define MUKCA_DIAGNOSE_MOUNTING_H

#include "diagnose/diagnose.h"

/* Where elasticity under the model's gravity does not explain a recording, diagnose it with gravity
 * along the other axes of the base frame.  If elastic causes under one of them explain it far
 * better, the diagnosis gets that gravity, and its causes are no longer certain: an effect outside
 * the catalogue would do as well.  Costs a few fits of the geometry with all springs, and a
 * diagnosis without held-out errors for each direction that they speak for.  A mukca_continue_fn,
 * the last one, since it leaves the regression with these springs; its context are the
 * mukca_diagnose_options.  Errors: as of mukca_diagnose. */
mukca_status mukca_mounting_compare(void *options, struct mukca_regression *regression,
                                    mukca_diagnosis *diagnosis, mukca_error *error);

#endif
