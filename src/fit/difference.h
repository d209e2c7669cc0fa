/* Difference of the errors of two models on the same samples. */
#ifndef MUKCA_FIT_DIFFERENCE_H
#define MUKCA_FIT_DIFFERENCE_H

#include "model/dataset.h"

typedef struct {
    int postures;             /* different ones; a repeated one counts once */
    double before_m, after_m; /* mean errors */
    double mean_m, sigma_m;   /* of after - before, and its standard error */
} mukca_difference;

/* Compare before[n_rows] and after[n_rows], m; NaN: not measured.  Errors: MUKCA_MEMORY. */
mukca_status mukca_difference_find(mukca_difference *difference, const double *before,
                                   const double *after, const mukca_dataset *data,
                                   mukca_error *error);

#endif
