/* Look-ups in a chain, its parameters from a geometry; the version of the library. */
#include <string.h>

#include "mukca/chain.h"
#include "mukca/version.h"

const char *mukca_version(void)
{
    return MUKCA_VERSION;
}

int mukca_chain_find_element(const mukca_chain *chain, const char *name)
{
    for (int k = 0; k < chain->n_elements; k++)
        if (!strcmp(chain->element[k].name, name)) return k;
    return -1;
}

const char *mukca_chain_joint_name(const mukca_chain *chain, int joint)
{
    return joint < 0 ? NULL : chain->element[chain->joint_element[joint]].name;
}

int mukca_chain_find_joint(const mukca_chain *chain, const char *name)
{
    const int k = mukca_chain_find_element(chain, name);
    return k < 0 ? -1 : chain->element[k].joint;
}

void mukca_geometry_theta(double *theta, const mukca_chain *chain, const mukca_geometry *geometry)
{
    for (int k = 0; k < chain->n_elements; k++) {
        memcpy(theta + 6 * k, geometry->origin[k].p, 3 * sizeof *theta);
        mukca_rotation_to_rpy(theta + 6 * k + 3, geometry->origin[k].R, chain->element[k].rpy);
    }
}
