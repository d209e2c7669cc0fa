/* Statistics of pose errors. */
#ifndef MUKCA_RECALIBRATE_ERRORS_H
#define MUKCA_RECALIBRATE_ERRORS_H

#include <math.h>

#include "model/dataset.h"
#include "mukca/chain.h"

/* Whether a row has an orientation. */
static inline bool mukca_pose_oriented(const mukca_dataset *log, int row)
{
    return log->quaternion && isfinite(log->quaternion[4 * (size_t)row]);
}

typedef struct {
    long n;
    double max, mean, m2; /* m2: sum of squares about the mean */
} mukca_moments;

typedef struct {
    mukca_moments length;  /* m; rad */
    mukca_moments axis[3]; /* absolute coordinates, of the rotation vector too */
    double median;         /* length; 0 without errors */
} mukca_vector_errors;

typedef struct {
    mukca_vector_errors position, rotation;
} mukca_pose_errors;

/* Standard deviation, 1 / (n - 1); 0 for n < 2. */
double mukca_moments_std(const mukca_moments *moments);

/* Errors of the poses of a log by a model.  Errors: MUKCA_MEMORY. */
mukca_status mukca_pose_errors_find(mukca_pose_errors *errors, const mukca_geometry *geometry,
                                    const mukca_dataset *log, mukca_error *error);

/* Copy of a log without the rows whose errors by the model are beyond 8 sigma, by the median of
 * all.  Errors: MUKCA_MEMORY. */
mukca_status mukca_pose_log_trim(mukca_dataset *kept, const mukca_geometry *geometry,
                                 const mukca_pose_errors *errors, const mukca_dataset *log,
                                 mukca_error *error);

#endif
