/* Gaussian prior of the geometry and its posterior given samples. */
#include "fit/posterior.h"

#include <string.h>

#include "math/dense.h"

void mukca_posterior_prior(double *sigma, const mukca_chain *chain,
                           const mukca_parameters *parameters)
{
    for (int i = 0; i < parameters->n; i++) {
        const int k = parameters->index[i] / MUKCA_PARAMETERS;
        const bool angle = parameters->index[i] % MUKCA_PARAMETERS >= 3;
        sigma[i] = k == mukca_chain_tip_element(chain) ? MUKCA_PRIOR_TOOL
                   : angle                             ? MUKCA_PRIOR_ANGLE
                                                       : MUKCA_PRIOR_LENGTH;
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

void mukca_linearisation_init(mukca_linearisation *at, const mukca_chain *chain,
                              const double *theta)
{
    memset(at, 0, sizeof *at);
    at->chain = chain;
    mukca_parameters_set(&at->parameters, chain, NULL, false);
    mukca_chain_theta(at->theta, chain);
    mukca_linearisation_move(at, theta ? theta : at->theta);
}

void mukca_linearisation_move(mukca_linearisation *at, const double *theta)
{
    memmove(at->theta, theta,
            (size_t)(MUKCA_PARAMETERS * at->chain->n_elements) * sizeof *at->theta);
    mukca_geometry_set(&at->geometry, at->chain, at->theta);
}

void mukca_linearisation_tip(double *J, int ld, double position[3], const mukca_linearisation *at,
                             const double *q)
{
    double all[3 * MUKCA_MAX_FREE];
    const int width = MUKCA_PARAMETERS * at->chain->n_elements;
    mukca_fk_parameter_jacobian(all, position, &at->geometry, at->theta, q);
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < at->parameters.n; c++)
            J[i * ld + c] = all[i * width + at->parameters.index[c]];
}
