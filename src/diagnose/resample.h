/* Resampling of the recording: what another recording of this arm would say. */
#ifndef MUKCA_DIAGNOSE_RESAMPLE_H
#define MUKCA_DIAGNOSE_RESAMPLE_H

#include "diagnose/scan.h"

/* Changes of a question's products g, delta[stride][MUKCA_DRAWS], by resamplings of the postures;
 * mean[stride]: coefficients of the set about whose residuals.  Memory comes from `pool`; NULL:
 * none. */
double *mukca_resample(mukca_pool *pool, const mukca_scan *scan, const mukca_question *question,
                       const double *mean);

#endif
