/* Rotations from angles, axes of a joint's frame; rigid-body transforms. */
#include "mukca/rotation.h"

#include <math.h>

void mukca_rotation_from_rpy(double R[9], const double rpy[3])
{
    const double cr = cos(rpy[0]), sr = sin(rpy[0]);
    const double cp = cos(rpy[1]), sp = sin(rpy[1]);
    const double cy = cos(rpy[2]), sy = sin(rpy[2]);
    R[0] = cy * cp, R[1] = cy * sp * sr - sy * cr, R[2] = cy * sp * cr + sy * sr;
    R[3] = sy * cp, R[4] = sy * sp * sr + cy * cr, R[5] = sy * sp * cr - cy * sr;
    R[6] = -sp, R[7] = cp * sr, R[8] = cp * cr;
}

void mukca_rotation_from_rpy_derivative(double dR[3][9], const double rpy[3])
{
    double R[9], turned[3], column[3];
    mukca_rotation_from_rpy(R, rpy);
    /* axes of roll, pitch and yaw in the outer frame */
    const double axes[3][3] = {{R[0], R[3], R[6]}, {-sin(rpy[2]), cos(rpy[2]), 0}, {0, 0, 1}};
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 3; c++) {
            for (int r = 0; r < 3; r++) column[r] = R[3 * r + c];
            mukca_cross(turned, axes[i], column);
            for (int r = 0; r < 3; r++) dR[i][3 * r + c] = turned[r];
        }
}

void mukca_rotation_transverse(double e1[3], double e2[3], const double axis[3])
{
    /* Duff et al., "Building an orthonormal basis, revisited", JCGT 6 (2017). */
    const double sign = copysign(1.0, axis[2]);
    const double a = -1.0 / (sign + axis[2]), b = axis[0] * axis[1] * a;
    e1[0] = 1 + sign * axis[0] * axis[0] * a, e1[1] = sign * b, e1[2] = -sign * axis[0];
    e2[0] = b, e2[1] = sign + axis[1] * axis[1] * a, e2[2] = -axis[1];
}

void mukca_frame_multiply(mukca_frame *C, const mukca_frame *A, const mukca_frame *B)
{
    mukca_frame out;
    mukca_mat3_mul(out.R, A->R, B->R);
    mukca_mat3_vec(out.p, A->R, B->p);
    for (int i = 0; i < 3; i++) out.p[i] += A->p[i];
    *C = out;
}
