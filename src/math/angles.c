/* Rotations as three turns about coordinate axes, in any order. */
#include "math/angles.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"

/* The axes of the turns, 0 to 2; true: about fixed axes. */
static bool read_axes(int axis[3], const char *convention)
{
    const bool fixed = convention[0] >= 'x';
    for (int i = 0; i < 3; i++) axis[i] = convention[i] - (fixed ? 'x' : 'X');
    return fixed;
}

bool mukca_angles_known(const char *convention)
{
    int axis[3];
    if (strcmp(convention, MUKCA_VECTOR) == 0) return true;
    if (strlen(convention) != 3) return false;
    read_axes(axis, convention);
    for (int i = 0; i < 3; i++)
        if (axis[i] < 0 || axis[i] > 2 || (i && axis[i] == axis[i - 1])) return false;
    return true;
}

void mukca_angles_to_rotation(double R[9], const double numbers[3], const char *convention)
{
    if (strcmp(convention, MUKCA_VECTOR) == 0) {
        mukca_rotation_exp(R, numbers);
        return;
    }
    int axis[3];
    const bool fixed = read_axes(axis, convention);
    memcpy(R, (const double[])MUKCA_IDENTITY, 9 * sizeof *R);
    for (int i = 0; i < 3; i++) {
        double w[3] = {0};
        w[axis[i]] = numbers[i];
        mukca_rotation_turn(R, w, !fixed);
    }
}

/* Bernardes and Viollet, "Quaternion to Euler angles conversion: a direct, general and
 * computationally efficient method", PLoS ONE 17 (2022), e0276302. */
void mukca_angles_from_rotation(double numbers[3], const double R[9], const char *convention)
{
    if (strcmp(convention, MUKCA_VECTOR) == 0) {
        mukca_rotation_log(numbers, R);
        return;
    }
    int axis[3];
    double q[4];
    const bool fixed = read_axes(axis, convention);
    const int i = axis[fixed ? 0 : 2], j = axis[1], last = axis[fixed ? 2 : 0];
    const bool same = i == last;
    const int k = same ? 3 - i - j : last;
    const double sign = (i - j) * (j - k) * (k - i) / 2.0;
    mukca_rotation_to_quaternion(q, R);
    const double a = same ? q[0] : q[0] - q[1 + j];
    const double b = same ? q[1 + i] : q[1 + i] + sign * q[1 + k];
    const double c = same ? q[1 + j] : q[1 + j] + q[0];
    const double d = sign * q[1 + k] - (same ? 0 : q[1 + i]);
    const double sum = atan2(b, a), difference = atan2(d, c);
    const double turn[3] = {sum - difference, 2 * atan2(hypot(c, d), hypot(a, b)),
                            sum + difference};
    for (int t = 0; t < 3; t++) {
        double angle = turn[fixed ? t : 2 - t];
        if (!same && t == 1) angle -= M_PI / 2;
        if (!same && t == (fixed ? 2 : 0)) angle *= sign;
        numbers[t] = remainder(angle, 2 * M_PI);
    }
}
