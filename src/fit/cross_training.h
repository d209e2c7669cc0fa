/* Errors on placements that were not used for training. */
#ifndef MUKCA_FIT_CROSS_TRAINING_H
#define MUKCA_FIT_CROSS_TRAINING_H

#include "fit/evaluate.h"

/* Result of one fit to some of the placements. */
typedef struct {
    char name[2 * MUKCA_NAME_SIZE]; /* of these placements, joined by +; or "all" */
    int placements;                 /* number of these placements */
    int n;
    const mukca_score *scores; /* [n] all placements with samples */
    double mean;               /* MAE over the other placements and the test data, m; NaN: none */
} mukca_cross_training;

/* Called after each fit; `share`: completed part of all fits.  Return false to interrupt. */
typedef bool mukca_cross_training_fn(void *context, const mukca_cross_training *result,
                                     double share);

/* Train on each placement of `data`, on each pair, and on all if more than two, with the defaults
 * of mukca_fit_run; score all of `data` and `test` (may be empty).  Errors: those of mukca_fit_run,
 * MUKCA_INTERRUPTED. */
mukca_status mukca_cross_training_run(const mukca_chain *chain, const mukca_dataset *data,
                                      const mukca_dataset *test, mukca_cross_training_fn *report,
                                      void *context, mukca_error *error);

#endif
