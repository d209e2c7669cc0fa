/* Forward kinematics of one configuration with displacements by effects: position, pose, frames;
 * derivatives by joint angles and by parameters. */
#include <string.h>

#include "math/sincos.h"
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

void mukca_fk_position(double position[3], const mukca_geometry *geometry, const double *q,
                       const mukca_displacement *displacement)
{
    mukca_frame tip;
    if (!displacement) {
        mukca_fk_tip(position, geometry, q);
        return;
    }
    mukca_fk_frames(NULL, &tip, geometry, q, displacement);
    memcpy(position, tip.p, sizeof tip.p);
}

MUKCA_CLONES void mukca_fk_jacobian(double *J, mukca_frame *T_base_tip,
                                    const mukca_geometry *geometry, const double *q,
                                    const mukca_displacement *displacement)
{
    const int n = geometry->n_joints;
    lanes axis[MUKCA_MAX_JOINTS][ROWS], origin[MUKCA_MAX_JOINTS][ROWS]; /* in base coordinates */
    columns F;
    joint_angles at;
    columns_base(&F, displacement);
    mukca_joint_angles_set(&at, geometry, q, displacement);
    for (int k = 0; k < geometry->n_elements; k++) {
        const int j = geometry->joint[k];
        columns_enter(&F, geometry, k);
        if (j < 0) continue;
        columns_displace(&F, j, displacement);
        memcpy(origin[j], F.column[3], sizeof origin[j]);
        columns_vector(axis[j], &F, geometry->axis[k]);
        columns_turn(&F, geometry, k, &at);
    }
    if (displacement) columns_move(&F, displacement->tip);
    if (T_base_tip) columns_frame(T_base_tip, &F);
    for (int k = 0; k < geometry->n_elements; k++) {
        const int j = geometry->joint[k];
        if (j < 0) continue;
        const bool slides = geometry->type[k] == MUKCA_PRISMATIC;
        const double *a = (const double *)axis[j], *at_joint = (const double *)origin[j];
        double lever[3], swept[3];
        for (int i = 0; i < 3; i++) lever[i] = COLUMN(&F, 3, i) - at_joint[i];
        mukca_cross(swept, a, lever);
        for (int i = 0; i < 3; i++) {
            J[i * n + j] = slides ? a[i] : swept[i];
            J[(3 + i) * n + j] = slides ? 0 : a[i];
        }
    }
}

MUKCA_CLONES void mukca_fk_parameter_jacobian(double *J, double position[3],
                                              const mukca_geometry *geometry, const double *theta,
                                              const double *q)
{
    enum { PADDED = (MUKCA_MAX_ELEMENTS + 3) / 4 * 4 };
    const int n = geometry->n_elements, width = MUKCA_PARAMETERS * n;
    double yaw[PADDED], s[PADDED], c[PADDED], origin[MUKCA_MAX_ELEMENTS][3];
    columns F;
    joint_angles at;
    yaw[0] = 0; /* for a chain without elements */
    for (int k = 0; k < n; k++) yaw[k] = theta[MUKCA_PARAMETERS * k + 5];
    mukca_sincos(s, c, yaw, n);
    mukca_joint_angles_set(&at, geometry, q, NULL);
    columns_base(&F, NULL);
    for (int k = 0; k < n; k++) { /* axes of an element's translations and rotations */
        const columns parent = F;
        columns_enter(&F, geometry, k);
        for (int i = 0; i < 3; i++) {
            double *to = J + i * width + MUKCA_PARAMETERS * k;
            for (int a = 0; a < 3; a++) to[a] = COLUMN(&parent, a, i);
            to[3] = COLUMN(&F, 0, i);
            to[4] = c[k] * to[1] - s[k] * to[0];
            to[5] = to[2];
            origin[k][i] = COLUMN(&F, 3, i);
        }
        columns_turn(&F, geometry, k, &at);
    }
    for (int k = 0; k < n; k++) {
        double *row = J + MUKCA_PARAMETERS * k, lever[3];
        for (int i = 0; i < 3; i++) lever[i] = COLUMN(&F, 3, i) - origin[k][i];
        for (int a = 3; a < MUKCA_PARAMETERS; a++) {
            const double axis[3] = {row[a], row[width + a], row[2 * width + a]};
            double swept[3];
            mukca_cross(swept, axis, lever);
            for (int i = 0; i < 3; i++) row[i * width + a] = swept[i];
        }
    }
    for (int i = 0; position && i < 3; i++) position[i] = COLUMN(&F, 3, i);
}
