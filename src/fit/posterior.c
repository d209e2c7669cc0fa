/* Gaussian prior of the geometry and its posterior given samples. */
#include "fit/posterior.h"

#include "math/dense.h"

static const double prior[MUKCA_PARAMETERS] = {
    MUKCA_PRIOR_LENGTH, MUKCA_PRIOR_LENGTH, MUKCA_PRIOR_LENGTH,
    MUKCA_PRIOR_ANGLE,  MUKCA_PRIOR_ANGLE,  MUKCA_PRIOR_ANGLE,
};

void mukca_posterior_prior(double *sigma, const mukca_linearisation *at)
{
    const int tip = mukca_chain_tip_element(at->chain);
    for (int i = 0; i < at->parameters.n; i++) {
        const int index = at->parameters.index[i];
        sigma[i] =
            index / MUKCA_PARAMETERS == tip ? MUKCA_PRIOR_TOOL : prior[index % MUKCA_PARAMETERS];
    }
}

void mukca_posterior_factor(double *L, const double *gram, const double *sigma, double noise, int n)
{
    for (int i = 0; i < n * n; i++) L[i] = gram[i] / (noise * noise);
    for (int i = 0; i < n; i++) L[i * n + i] += 1 / (sigma[i] * sigma[i]);
    mukca_dense_cholesky(L, n); /* positive definite: every parameter has a prior */
}

double mukca_posterior_variance(const double *L, double *a, int n)
{
    double sum = 0;
    mukca_dense_forward(a, 1, L, n);
    for (int i = 0; i < n; i++) sum += a[i] * a[i];
    return sum;
}
