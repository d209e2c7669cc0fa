/* Forward kinematics of one configuration: position of the tip. */
#include <string.h>

#include "math/sincos.h"
#include "model/turn.h"

void mukca_joint_angles_set(joint_angles *at, const mukca_geometry *geometry, const double *q,
                            const mukca_displacement *displacement)
{
    const int n = geometry->n_joints;
    at->moved[0] = 0; /* for an arm without joints */
    at->q = displacement ? at->moved : q;
    for (int j = 0; displacement && j < n; j++) at->moved[j] = q[j] + displacement->q[j];
    mukca_sincos(at->s, at->c, at->q, n);
}

MUKCA_CLONES void mukca_fk_tip(double position[3], const mukca_geometry *geometry, const double *q)
{
    double v[3] = {0, 0, 0};
    joint_angles at;
    mukca_joint_angles_set(&at, geometry, q, NULL);
    for (int k = geometry->n_elements - 1; k >= 0; k--) {
        back_vector(v, geometry, k, &at);
        place_vector(v, &geometry->origin[k]);
    }
    memcpy(position, v, sizeof v);
}
