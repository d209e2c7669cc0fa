/* A chain's parameters and geometry. */
#include "mukca/chain.h"

#include <string.h>

const char *const mukca_joint_type_name[4] = {"fixed", "revolute", "continuous", "prismatic"};

const char *const mukca_parameter_name[MUKCA_PARAMETERS] = {"x", "y", "z", "roll", "pitch", "yaw"};

void mukca_chain_theta(double *theta, const mukca_chain *chain)
{
    for (int k = 0; k < chain->n_elements; k++) {
        memcpy(theta + 6 * k, chain->element[k].xyz, 3 * sizeof *theta);
        memcpy(theta + 6 * k + 3, chain->element[k].rpy, 3 * sizeof *theta);
    }
}

void mukca_geometry_set(mukca_geometry *geometry, const mukca_chain *chain, const double *theta)
{
    geometry->n_elements = chain->n_elements;
    geometry->n_joints = chain->n_joints;
    for (int k = 0; k < chain->n_elements; k++) {
        const mukca_element *e = &chain->element[k];
        mukca_rotation_from_rpy(geometry->origin[k].R, theta ? theta + 6 * k + 3 : e->rpy);
        memcpy(geometry->origin[k].p, theta ? theta + 6 * k : e->xyz, 3 * sizeof(double));
        memcpy(geometry->axis[k], e->axis, sizeof e->axis);
        geometry->type[k] = (signed char)e->type;
        geometry->joint[k] = (signed char)e->joint;
        const bool on_z = e->axis[0] == 0 && e->axis[1] == 0;
        geometry->axis_z[k] = (signed char)(!on_z ? 0 : e->axis[2] > 0 ? 1 : -1);
    }
}
