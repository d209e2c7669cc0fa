/* Rotations as three numbers: turns about coordinate axes, or a rotation vector. */
#ifndef MUKCA_MATH_ANGLES_H
#define MUKCA_MATH_ANGLES_H

#include <stdbool.h>

/* A convention is "vector" (rotation vector), or the axes of three turns in their order: in upper
 * case about the turned axes (intrinsic), in lower case about the fixed ones (extrinsic). */
#define MUKCA_VECTOR "vector"

bool mukca_angles_known(const char *convention);

/* Rotation of the numbers, rad; they are those of the convention's letters in order. */
void mukca_angles_to_rotation(double R[9], const double numbers[3], const char *convention);

/* The numbers of a rotation, the second turn in [-pi/2, pi/2], or in [0, pi] if the first and the
 * third axis are the same. */
void mukca_angles_from_rotation(double numbers[3], const double R[9], const char *convention);

#endif
