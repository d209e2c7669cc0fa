/* Mounting of the arm: gravity in a direction other than the model's. */
#ifndef MUKCA_DIAGNOSE_MOUNTING_H
#define MUKCA_DIAGNOSE_MOUNTING_H

#include "diagnose/diagnose.h"

/* If elastic causes under the model's gravity do not explain a recording, weigh them with gravity
 * along the other axes of the base frame.  If they are far more probable there than all causes
 * found here, the diagnosis receives this gravity, and its causes become uncertain: an effect
 * outside the catalogue explains the data as well.  A mukca_continue_fn with the
 * mukca_diagnose_options as context; must be the last one, since the regression is left under that
 * gravity.  Errors: MUKCA_MEMORY. */
mukca_status mukca_mounting_compare(void *options, struct mukca_regression *regression,
                                    mukca_diagnosis *diagnosis, mukca_error *error);

#endif
