/* Sine and cosine of an array of angles.
 *
 * Up to |x| = MUKCA_SINCOS_LARGEST the error is below 1 ulp (largest found: 0.91, against 113
 * bits); beyond, and for infinities and NaN, the C library is used.  No operation is contracted or
 * reassociated: the bits of a result depend neither on the angle's position in the array nor on the
 * processor. */
#ifndef MUKCA_MATH_SINCOS_H
#define MUKCA_MATH_SINCOS_H

#include <stdbool.h>

#define MUKCA_SINCOS_LARGEST 0x1p20

/* s[i], c[i] := sine, cosine of x[i], rad.  s and c must not overlap x and need room for n rounded
 * up to a multiple of 4. */
void mukca_sincos(double *s, double *c, const double *x, int n);

/* The same without the C library; false: an angle exceeds MUKCA_SINCOS_LARGEST and its results are
 * invalid. */
bool mukca_sincos_near(double *s, double *c, const double *x, int n);

#endif
