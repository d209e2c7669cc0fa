/* Forward kinematics of one configuration: pose, frames. */
#include "model/columns.h"

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
