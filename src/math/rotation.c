/* Rotations from angles and about axes; rigid-body transforms. */
#include "mukca/rotation.h"

#include <math.h>

#include "math/sincos.h"

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

void mukca_rotation_exp(double R[9], const double w[3])
{
    const double t2 = mukca_dot3(w, w);
    double a, b;     /* sin t / t, (1 - cos t) / t^2 */
    if (t2 < 0.01) { /* small angles: the next terms of the series are below 3e-18 */
        a = 1 - t2 * (1.0 / 6 - t2 * (1.0 / 120 - t2 * (1.0 / 5040 - t2 * (1.0 / 362880))));
        b = 0.5 - t2 * (1.0 / 24 - t2 * (1.0 / 720 - t2 * (1.0 / 40320 - t2 * (1.0 / 3628800))));
    } else {
        const double t = sqrt(t2), angle[4] = {t, 0.5 * t};
        double s[4], c[4];
        const bool near = mukca_sincos_near(s, c, angle, 2);
        a = near ? s[0] / t : (double)NAN, b = 2 * s[1] * s[1] / t2;
    }
    const double c = 1 - b * t2;
    R[0] = c + b * w[0] * w[0], R[4] = c + b * w[1] * w[1], R[8] = c + b * w[2] * w[2];
    R[1] = b * w[0] * w[1] - a * w[2], R[3] = b * w[0] * w[1] + a * w[2];
    R[2] = b * w[0] * w[2] + a * w[1], R[6] = b * w[0] * w[2] - a * w[1];
    R[5] = b * w[1] * w[2] - a * w[0], R[7] = b * w[1] * w[2] + a * w[0];
}

void mukca_rotation_about(double R[9], const double axis[3], double angle)
{
    const double w[3] = {axis[0] * angle, axis[1] * angle, axis[2] * angle};
    mukca_rotation_exp(R, w);
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
