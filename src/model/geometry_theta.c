/* Parameters of a geometry. */
#include <string.h>

#include "mukca/chain.h"

void mukca_geometry_theta(double *theta, const mukca_chain *chain, const mukca_geometry *geometry)
{
    for (int k = 0; k < chain->n_elements; k++) {
        memcpy(theta + 6 * k, geometry->origin[k].p, 3 * sizeof *theta);
        mukca_rotation_to_rpy(theta + 6 * k + 3, geometry->origin[k].R, chain->element[k].rpy);
    }
}
