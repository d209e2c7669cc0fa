/* Mounting of the arm: gravity in a direction other than the model's. */
#ifndef MUKCA_DIAGNOSE_MOUNTING_H
#define MUKCA_DIAGNOSE_MOUNTING_H

#include "diagnose/diagnose.h"

/* If elastic causes under the model's gravity do not explain a recording, diagnose it with gravity
 * along the other axes of the base frame.  If elastic causes under one of them have far higher
 * evidence, the diagnosis receives this gravity, and its causes become uncertain: an effect outside
 * the catalogue explains the data as well.  Costs a few fits of the geometry with all elastic
 * effects, and a diagnosis without cross-validation for each direction with sufficient evidence.  A
 * mukca_continue_fn with the mukca_diagnose_options as context; must be the last one, since the
 * elastic effects remain in the regression.  Errors: as of mukca_diagnose. */
mukca_status mukca_mounting_compare(void *options, struct mukca_regression *regression,
                                    mukca_diagnosis *diagnosis, mukca_error *error);

#endif
