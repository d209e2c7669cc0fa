/* Held-out error of a calibration: each fold of the samples is predicted by a fit to the others. */
#ifndef MUKCA_FIT_CROSS_VALIDATION_H
#define MUKCA_FIT_CROSS_VALIDATION_H

#include "fit/evaluate.h"

typedef struct {
    int folds;              /* 0: too few samples, nothing is predicted */
    bool placements;        /* folds are placements; else blocks of consecutive samples */
    mukca_dataset data;     /* the samples, or a part of a long recording */
    double *before, *after; /* [data.n_rows] errors of held-out samples by the nominal model, with
                               the free frames aligned, and by the fit, m; NaN: not measured */
} mukca_cross_validation;

/* Fit as mukca_fit_run does, by Gauss-Newton from options->start.  Errors: those of mukca_fit_run.
 */
mukca_status mukca_fit_cross_validate(mukca_cross_validation *result, const mukca_chain *chain,
                                      const mukca_dataset *data, const mukca_fit_options *options,
                                      mukca_error *error);
void mukca_cross_validation_free(mukca_cross_validation *result);

#endif
