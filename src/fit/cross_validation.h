/* Held-out error of a calibration: each fold of the samples is predicted by a fit to the others. */
#ifndef MUKCA_FIT_CROSS_VALIDATION_H
#define MUKCA_FIT_CROSS_VALIDATION_H

#include "fit/evaluate.h"

typedef struct {
    int folds;            /* 0: too few samples, the errors are NaN */
    int samples;          /* samples predicted, of a long recording; 0: all */
    bool placements;      /* folds are placements; else blocks of consecutive samples */
    double nominal, mean; /* mean held-out errors (mukca_score.mae) of all samples, m; nominal with
                             the free frames aligned */
} mukca_cross_validation;

/* Fit as mukca_fit_run does, by Gauss-Newton from options->start.  Errors: those of mukca_fit_run.
 */
mukca_status mukca_fit_cross_validate(mukca_cross_validation *result, const mukca_chain *chain,
                                      const mukca_dataset *data, const mukca_fit_options *options,
                                      mukca_error *error);

#endif
