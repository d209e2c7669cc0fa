/* Forward kinematics of one configuration: position. */
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

MUKCA_CLONES void mukca_fk_position(double position[3], const mukca_geometry *geometry,
                                    const double *q, const mukca_displacement *displacement)
{
    const mukca_displacement *d = displacement;
    double v[3] = {0, 0, 0}, u[3], R[9];
    joint_angles at;
    mukca_joint_angles_set(&at, geometry, q, d);
    if (d) memcpy(v, d->tip, sizeof v);
    for (int k = geometry->n_elements - 1; k >= 0; k--) {
        const int j = geometry->joint[k];
        if (geometry->type[k] == MUKCA_PRISMATIC)
            for (int i = 0; i < 3; i++) v[i] += at.q[j] * geometry->axis[k][i];
        else if (j >= 0)
            turn_vector(v, geometry, k, at.s[j], at.c[j]);
        const double *w = joint_rotation(d, j);
        if (w) {
            mukca_rotation_exp(R, w);
            mukca_mat3_vec(u, R, v);
            memcpy(v, u, sizeof v);
        }
        place_vector(v, &geometry->origin[k]);
    }
    memcpy(position, v, sizeof v);
    if (!d || !d->any_rotation) return;
    mukca_rotation_exp(R, d->base);
    mukca_mat3_vec(position, R, v);
}
