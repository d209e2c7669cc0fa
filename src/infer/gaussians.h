/* A mixture of Gaussians. */
#ifndef MUKCA_INFER_GAUSSIANS_H
#define MUKCA_INFER_GAUSSIANS_H

#include <stdbool.h>

enum { MUKCA_MOST_GAUSSIANS = 60 };

typedef struct {
    int n;
    double mean[MUKCA_MOST_GAUSSIANS], deviation[MUKCA_MOST_GAUSSIANS],
        weight[MUKCA_MOST_GAUSSIANS];
} mukca_gaussians;

/* Add one, if its mean is finite and there is room. */
void mukca_gaussians_add(mukca_gaussians *m, double mean, double variance, double weight);

/* A value with its 95 % interval; NaN: none. */
typedef struct {
    double value, low, high;
} mukca_estimate;

#define MUKCA_ESTIMATE_NONE ((mukca_estimate){NAN, NAN, NAN})

/* Mean and 95 % interval of `scale` times the mixture; of a positive quantity none is below 0. */
mukca_estimate mukca_gaussians_estimate(const mukca_gaussians *m, double scale, bool positive);

#endif
