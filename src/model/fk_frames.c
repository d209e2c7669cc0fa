/* Forward kinematics of one configuration with displacements by effects: position, pose, frames. */
#include <string.h>

#include "model/columns.h"

MUKCA_CLONES void mukca_fk_position(double position[3], const mukca_geometry *geometry,
                                    const double *q, const mukca_displacement *displacement)
{
    const mukca_displacement *d = displacement;
    double v[3] = {0, 0, 0}, u[3], R[9];
    joint_angles at;
    mukca_joint_angles_set(&at, geometry, q, d);
    if (d) memcpy(v, d->tip, sizeof v);
    for (int k = geometry->n_elements - 1; k >= 0; k--) {
        back_vector(v, geometry, k, &at);
        const double *w = joint_rotation(d, geometry->joint[k]);
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

MUKCA_CLONES void mukca_fk_frames(mukca_frame *before, mukca_frame *tip,
                                  const mukca_geometry *geometry, const double *q,
                                  const mukca_displacement *displacement)
{
    columns F;
    joint_angles at;
    columns_base(&F, displacement);
    mukca_joint_angles_set(&at, geometry, q, displacement);
    for (int k = 0; k < geometry->n_elements; k++) {
        columns_enter(&F, geometry, k);
        if (before) columns_frame(&before[k], &F);
        columns_displace(&F, geometry->joint[k], displacement);
        columns_turn(&F, geometry, k, &at);
    }
    if (!tip) return;
    if (displacement) columns_move(&F, displacement->tip);
    columns_frame(tip, &F);
}

void mukca_fk_pose(mukca_frame *T_base_tip, const mukca_geometry *geometry, const double *q,
                   const mukca_displacement *displacement)
{
    mukca_fk_frames(NULL, T_base_tip, geometry, q, displacement);
}
