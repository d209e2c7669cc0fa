/* Statistics of pose errors, accumulated row by row in constant memory. */
#ifndef MUKCA_RECALIBRATE_ERRORS_H
#define MUKCA_RECALIBRATE_ERRORS_H

#include "recalibrate/model.h"

typedef struct {
    long n;
    double max, mean, m2; /* m2: sum of squares about the mean */
} mukca_moments;

enum { MUKCA_HISTOGRAM_BINS = 70 * 32 };

/* Counts on a logarithmic scale, 32 bins per power of two from 2^-60. */
typedef struct {
    double total;
    unsigned count[MUKCA_HISTOGRAM_BINS];
} mukca_histogram;

typedef struct {
    mukca_moments position, rotation;                 /* length, m; angle, rad */
    mukca_moments position_axis[3], rotation_axis[3]; /* absolute; rotation: vector of R'R~ - I */
    mukca_histogram position_histogram, rotation_histogram;
} mukca_pose_errors;

void mukca_pose_errors_add(mukca_pose_errors *errors, const mukca_pose_look *look);

void mukca_moments_add(mukca_moments *moments, double x);

/* Standard deviation, 1 / (n - 1); 0 for n < 2. */
double mukca_moments_std(const mukca_moments *moments);

/* Median within 1 %; 0 for an empty histogram. */
double mukca_histogram_median(const mukca_histogram *histogram);

#endif
