/* Derivatives of the tip with respect to the free parameters, one posture at a time. */
#include "fit/linearisation.h"

#include <string.h>

#include "fit/selection.h"

mukca_status mukca_linearisation_init(mukca_linearisation *at, const mukca_chain *chain,
                                      const double *theta, mukca_error *error)
{
    const mukca_selection standard = {0};
    memset(at, 0, sizeof *at);
    at->chain = chain;
    mukca_chain_theta(at->theta, chain);
    mukca_linearisation_move(at, theta ? theta : at->theta);
    return mukca_parameters_select(&at->parameters, chain, &standard, error);
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
