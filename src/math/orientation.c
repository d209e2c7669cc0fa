/* Rotations as angles, rotation vectors and quaternions. */
#include <math.h>

#include "math/sincos.h"
#include "mukca/rotation.h"

/* `angle` plus the multiple of 2 pi that brings it closest to `near`. */
static double unwrap(double angle, double near)
{
    return angle + 2 * M_PI * round((near - angle) / (2 * M_PI));
}

static double triple_distance(const double a[3], const double b[3])
{
    return fabs(a[0] - b[0]) + fabs(a[1] - b[1]) + fabs(a[2] - b[2]);
}

void mukca_rotation_to_rpy(double rpy[3], const double R[9], const double near[3])
{
    const double cp = hypot(R[0], R[3]);
    rpy[1] = atan2(-R[6], cp);
    if (cp > 1e-9) {
        rpy[0] = atan2(R[7], R[8]);
        rpy[2] = atan2(R[3], R[0]);
        if (near) {
            double other[3] = {unwrap(rpy[0] + M_PI, near[0]), unwrap(M_PI - rpy[1], near[1]),
                               unwrap(rpy[2] + M_PI, near[2])};
            for (int i = 0; i < 3; i++) rpy[i] = unwrap(rpy[i], near[i]);
            if (triple_distance(other, near) < triple_distance(rpy, near))
                for (int i = 0; i < 3; i++) rpy[i] = other[i];
        }
        return;
    }
    /* Gimbal lock: only yaw - roll (pitch +90) or yaw + roll (pitch -90) is defined. */
    const double sum = atan2(-R[1], R[4]); /* yaw of the rotation with roll = 0 */
    rpy[0] = near ? near[0] : 0;
    rpy[2] = R[6] < 0 ? sum + rpy[0] : sum - rpy[0];
    if (near) rpy[2] = unwrap(rpy[2], near[2]);
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

void mukca_rotation_log(double w[3], const double R[9])
{
    const double half[3] = {0.5 * (R[7] - R[5]), 0.5 * (R[2] - R[6]), 0.5 * (R[3] - R[1])};
    const double s2 = mukca_dot3(half, half);  /* sin^2 */
    if (s2 < 1e-4 && R[0] + R[4] + R[8] > 0) { /* asin(s) / s to 3e-18 */
        const double f = 1 + s2 * (1.0 / 6 + s2 * (3.0 / 40 + s2 * (15.0 / 336)));
        for (int i = 0; i < 3; i++) w[i] = f * half[i];
        return;
    }
    double q[4];
    mukca_rotation_to_quaternion(q, R);
    const double s = sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double scale = s < 1e-12 ? 2 : 2 * atan2(s, q[0]) / s;
    for (int i = 0; i < 3; i++) w[i] = scale * q[1 + i];
}

void mukca_rotation_difference(double w[3], const double A[9], const double B[9])
{
    double off[9];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) off[3 * i + j] = mukca_dot3(A + 3 * i, B + 3 * j);
    mukca_rotation_log(w, off);
}

double mukca_rotation_between(const double A[9], const double B[9])
{
    double w[3];
    mukca_rotation_difference(w, A, B);
    return mukca_norm3(w);
}

void mukca_rotation_to_quaternion(double q[4], const double R[9])
{
    /* The largest of the four squares is at least 1/4: no cancellation (Shepperd 1978). */
    const double square[4] = {1 + R[0] + R[4] + R[8], 1 + R[0] - R[4] - R[8],
                              1 - R[0] + R[4] - R[8], 1 - R[0] - R[4] + R[8]};
    int k = 0;
    for (int i = 1; i < 4; i++)
        if (square[i] > square[k]) k = i;
    const double r = sqrt(square[k]), s = 0.5 / r;
    const double d[3] = {R[7] - R[5], R[2] - R[6], R[3] - R[1]};
    const double xy = R[1] + R[3], xz = R[2] + R[6], yz = R[5] + R[7];
    const double rows[4][4] = {{0.5 * r, d[0] * s, d[1] * s, d[2] * s},
                               {d[0] * s, 0.5 * r, xy * s, xz * s},
                               {d[1] * s, xy * s, 0.5 * r, yz * s},
                               {d[2] * s, xz * s, yz * s, 0.5 * r}};
    const double sign = rows[k][0] < 0 ? -1 : 1;
    for (int i = 0; i < 4; i++) q[i] = sign * rows[k][i];
}

void mukca_rotation_from_quaternion(double R[9], const double q[4])
{
    const double n2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    const double s = n2 > 0 ? 2 / n2 : 0;
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    R[0] = 1 - s * (y * y + z * z), R[1] = s * (x * y - w * z), R[2] = s * (x * z + w * y);
    R[3] = s * (x * y + w * z), R[4] = 1 - s * (x * x + z * z), R[5] = s * (y * z - w * x);
    R[6] = s * (x * z - w * y), R[7] = s * (y * z + w * x), R[8] = 1 - s * (x * x + y * y);
}
