/* The verdict of a calibration, for its offsets table. */
#ifndef MUKCA_FIT_ACCEPT_H
#define MUKCA_FIT_ACCEPT_H

#include "arm/offsets.h"
#include "fit/cross_validation.h"

/* Offsets table of a fit, without a verdict. */
void mukca_fit_offsets(mukca_offsets *offsets, const mukca_fit *fit);

/* Inputs of the fit. */
typedef struct {
    const mukca_chain *chain; /* as given to mukca_fit_run, like data and options */
    const mukca_dataset *data;
    const mukca_fit_options *options;
    const mukca_score *test; /* [2] means on held-out samples, nominal and calibrated; NULL: the fit
                                is cross-validated */
} mukca_accept_task;

/* Verdict on the table of a fit, from held-out errors.  Errors: those of mukca_fit_run. */
mukca_status mukca_fit_accept(mukca_offsets *offsets, const mukca_fit *fit,
                              const mukca_accept_task *task, mukca_error *error);

#endif
