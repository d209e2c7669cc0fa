/* Rotations and rigid-body transforms: 3x3 row-major matrices, RPY, axis-angle, quaternions (w
 * first). */
#ifndef MUKCA_ROTATION_H
#define MUKCA_ROTATION_H

#include <math.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A rigid transform: x_out = R x_in + p.  R is row-major 3x3, p in metres. */
typedef struct {
    double R[9];
    double p[3];
} mukca_frame;

/* Initialiser of a rotation matrix: no rotation. */
#define MUKCA_IDENTITY            \
    {                             \
        1, 0, 0, 0, 1, 0, 0, 0, 1 \
    }

/* R = Rz(yaw) Ry(pitch) Rx(roll), the convention of URDF (rad). */
void mukca_rotation_from_rpy(double R[9], const double rpy[3]);

/* Derivatives of mukca_rotation_from_rpy with respect to roll, pitch, yaw: dR[i] = dR/drpy[i]. */
void mukca_rotation_from_rpy_derivative(double dR[3][9], const double rpy[3]);

/* RPY of a rotation; at pitch = +-90 deg roll is set to 0 (gimbal lock).  `near` (may be NULL):
 * return the equivalent triple closest to it. */
void mukca_rotation_to_rpy(double rpy[3], const double R[9], const double near[3]);

/* R = exp([w]x): rotation by |w| rad about w; accurate to rounding, also for |w| -> 0; NaN beyond
 * 2^20 rad. */
void mukca_rotation_exp(double R[9], const double w[3]);

/* Rotation vector of R, |w| in [0, pi]; accurate near 0 and near pi. */
void mukca_rotation_log(double w[3], const double R[9]);

/* w = log(A B'): the rotation vector from B to A. */
void mukca_rotation_difference(double w[3], const double A[9], const double B[9]);

/* Angle of the rotation that takes A to B, rad, in [0, pi]. */
double mukca_rotation_between(const double A[9], const double B[9]);

/* R about a unit axis by angle (Rodrigues). */
void mukca_rotation_about(double R[9], const double axis[3], double angle);

/* Unit quaternion (w, x, y, z), w >= 0, of a rotation, and back (normalised first; 0 yields I). */
void mukca_rotation_to_quaternion(double q[4], const double R[9]);
void mukca_rotation_from_quaternion(double R[9], const double q[4]);

/* The rotation R that minimises sum |b - R a|^2, from H = sum a b' (Kabsch 1976); if the points lie
 * on one line, that which is nearest to the R given. */
void mukca_rotation_nearest(double R[9], const double H[9]);

/* Two unit vectors e1, e2 with e1 x e2 = axis (unit), without a jump near +-z. */
void mukca_rotation_transverse(double e1[3], double e2[3], const double axis[3]);

/* C = A B for frames; C may be A or B. */
void mukca_frame_multiply(mukca_frame *C, const mukca_frame *A, const mukca_frame *B);

/* Small inline kernels.  Outputs must not overlap inputs. */
static inline void mukca_mat3_mul(double C[9], const double A[9], const double B[9])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            C[3 * i + j] = A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j];
}

static inline void mukca_mat3_vec(double y[3], const double A[9], const double x[3])
{
    for (int i = 0; i < 3; i++) y[i] = A[3 * i] * x[0] + A[3 * i + 1] * x[1] + A[3 * i + 2] * x[2];
}

/* y = A' x */
static inline void mukca_mat3_tvec(double y[3], const double A[9], const double x[3])
{
    for (int i = 0; i < 3; i++) y[i] = A[i] * x[0] + A[3 + i] * x[1] + A[6 + i] * x[2];
}

/* C = A' B */
static inline void mukca_mat3_tmul(double C[9], const double A[9], const double B[9])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            C[3 * i + j] = A[i] * B[j] + A[3 + i] * B[3 + j] + A[6 + i] * B[6 + j];
}

static inline void mukca_cross(double c[3], const double a[3], const double b[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static inline double mukca_dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double mukca_norm3(const double a[3])
{
    return sqrt(mukca_dot3(a, a));
}

static inline double mukca_distance3(const double a[3], const double b[3])
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return mukca_norm3(d);
}

/* Largest difference of n numbers, as of the angles of two postures. */
static inline double mukca_largest_difference(const double *a, const double *b, int n)
{
    double most = 0;
    for (int i = 0; i < n; i++) most = fmax(most, fabs(a[i] - b[i]));
    return most;
}

#ifdef __cplusplus
}
#endif
#endif
