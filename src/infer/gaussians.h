/* A mixture of Gaussians. */
#ifndef MUKCA_INFER_GAUSSIANS_H
#define MUKCA_INFER_GAUSSIANS_H

enum { MUKCA_MOST_GAUSSIANS = 60 };

typedef struct {
    int n;
    double mean[MUKCA_MOST_GAUSSIANS], deviation[MUKCA_MOST_GAUSSIANS],
        weight[MUKCA_MOST_GAUSSIANS];
} mukca_gaussians;

/* Add one, if its mean is finite and there is room. */
void mukca_gaussians_add(mukca_gaussians *m, double mean, double variance, double weight);

double mukca_gaussians_quantile(const mukca_gaussians *m, double p);

#endif
