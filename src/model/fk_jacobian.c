/* Derivatives of forward kinematics by the joints and by the parameters. */
#include <math.h>
#include <string.h>

#include "model/turn.h"

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

/* Angular velocity of exp([w]x) as w changes by `rate`: the left Jacobian of SO(3); its series is
 * exact to 1e-9 up to |w| = 0.2 rad. */
static void angular_rate(double omega[3], const double w[3], const double rate[3])
{
    const double t2 = mukca_dot3(w, w);
    const double a = 0.5 - t2 / 24 + t2 * t2 / 720, b = 1.0 / 6 - t2 / 120 + t2 * t2 / 5040;
    double once[3], twice[3];
    mukca_cross(once, w, rate);
    mukca_cross(twice, w, once);
    for (int i = 0; i < 3; i++) omega[i] = rate[i] + a * once[i] + b * twice[i];
}

void mukca_fk_displacement_rate(double velocity[6], const mukca_geometry *geometry, const double *q,
                                const mukca_displacement *displacement,
                                const mukca_displacement *rate)
{
    mukca_frame before[MUKCA_MAX_ELEMENTS], tip;
    double R[9], omega[3], local[3], swept[3];
    mukca_fk_frames(before, &tip, geometry, q, displacement);
    angular_rate(omega, displacement->base, rate->base);
    mukca_mat3_vec(local, tip.R, rate->tip);
    mukca_cross(swept, omega, tip.p);
    for (int i = 0; i < 3; i++) velocity[i] = local[i] + swept[i], velocity[3 + i] = omega[i];
    for (int k = 0; k < geometry->n_elements; k++) {
        const int j = geometry->joint[k];
        if (j < 0) continue;
        const bool slides = geometry->type[k] == MUKCA_PRISMATIC;
        double axis[3], slide[3], lever[3];
        mukca_rotation_exp(R, displacement->rotation[j]);
        mukca_mat3_vec(axis, R, geometry->axis[k]);
        angular_rate(local, displacement->rotation[j], rate->rotation[j]);
        for (int i = 0; i < 3 && !slides; i++) local[i] += rate->q[j] * axis[i];
        mukca_mat3_vec(omega, before[k].R, local);
        mukca_mat3_vec(slide, before[k].R, axis);
        for (int i = 0; i < 3; i++) lever[i] = tip.p[i] - before[k].p[i];
        mukca_cross(swept, omega, lever);
        for (int i = 0; i < 3; i++) {
            velocity[i] += swept[i] + (slides ? rate->q[j] * slide[i] : 0);
            velocity[3 + i] += omega[i];
        }
    }
}

void mukca_fk_parameter_jacobian(double *J, double position[3], const mukca_geometry *geometry,
                                 const double *theta, const double *q)
{
    const int n = geometry->n_elements, width = MUKCA_PARAMETERS * n;
    double parent[MUKCA_MAX_ELEMENTS][9]; /* orientation of each element's parent frame */
    double v[3] = {0, 0, 0}, s[MUKCA_MAX_JOINTS], c[MUKCA_MAX_JOINTS];
    double R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    mukca_sincos(s, c, q, geometry->n_joints);
    for (int k = 0; k < n; k++) {
        const int j = geometry->joint[k];
        double turned[9];
        memcpy(parent[k], R, sizeof R);
        mukca_mat3_mul(turned, R, geometry->origin[k].R);
        memcpy(R, turned, sizeof R);
        if (j < 0 || geometry->type[k] == MUKCA_PRISMATIC) continue;
        for (int row = 0; row < 3; row++) turn_vector(R + 3 * row, geometry, k, -s[j], c[j]);
    }
    for (int k = n - 1; k >= 0; k--) {
        const int j = geometry->joint[k];
        const double *O = geometry->origin[k].R, yaw = theta[6 * k + 5];
        /* roll, pitch and yaw turn about these axes of the parent's frame */
        const double axes[3][3] = {{O[0], O[3], O[6]}, {-sin(yaw), cos(yaw), 0}, {0, 0, 1}};
        double u[3], turned[3], column[3];
        if (j >= 0 && geometry->type[k] == MUKCA_PRISMATIC)
            for (int i = 0; i < 3; i++) v[i] += q[j] * geometry->axis[k][i];
        else if (j >= 0)
            turn_vector(v, geometry, k, s[j], c[j]);
        mukca_mat3_vec(u, O, v);
        for (int i = 0; i < 3; i++) {
            mukca_cross(turned, axes[i], u);
            mukca_mat3_vec(column, parent[k], turned);
            for (int row = 0; row < 3; row++) {
                J[row * width + 6 * k + i] = parent[k][3 * row + i];
                J[row * width + 6 * k + 3 + i] = column[row];
            }
        }
        for (int i = 0; i < 3; i++) v[i] = u[i] + geometry->origin[k].p[i];
    }
    if (position) memcpy(position, v, sizeof v);
}
