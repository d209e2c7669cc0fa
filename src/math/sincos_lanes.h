/* Sine and cosine of MUKCA_LANES angles at a time: the kernel of sincos.h. */
#ifndef MUKCA_MATH_SINCOS_LANES_H
#define MUKCA_MATH_SINCOS_LANES_H

#include <stdint.h>

#include "math/four.h"
#include "math/sincos.h"

/* The kernel, for MUKCA_LANES angles of |x| <= MUKCA_SINCOS_LARGEST; others set bits in `wide`, and
 * their results are invalid.
 *
 * Reduction to [-pi/4, pi/4] by a multiple n of pi/2 in four parts (Cody and Waite 1980): products
 * of n with the first three, of 33 bits, are exact, and the rounding errors of the subtractions are
 * compensated.  The parts represent pi/2 to 2^-157, which keeps the relative error small close to
 * multiples of pi/2, too.  Polynomials: the minimax ones of fdlibm (k_sin.c, k_cos.c), accurate to
 * 2^-58.  The sine of |x| gets the sign of x, also for zero. */
MUKCA_INLINE void sincos_lanes(double *s, double *c, lane_bits *wide, const double *angle)
{
    const lane_bits given = LANE_BITS(LOAD_LANES(angle));
    const lanes x = BITS_LANES(given & INT64_MAX);
    *wide |= NOT_WITHIN(x, MUKCA_SINCOS_LARGEST);
    const lanes shifted = x * 0x1.45f306dc9c883p-1 + 0x1.8p52; /* rounds; the low bits are n */
    const lanes n = shifted - 0x1.8p52;
    const lane_bits quadrant = LANE_BITS(shifted);
    const lanes first = x - n * 0x1.921fb544p+0;
    const lanes part2 = n * 0x1.0b4611a6p-34, second = first - part2;
    const lanes part3 = n * 0x1.3198a2ep-69, third = second - part3;
    const lanes rest =
        (n * 0x1.b839a252049c1p-104 - ((second - third) - part3)) - ((first - second) - part2);
    const lanes r = third - rest, low = (third - r) - rest;
    const lanes z = r * r, zz = z * z, half = 0.5 * z, whole = 1 - half;
    const lanes sines = (-0x1.5555555555549p-3 + z * 0x1.111111110f8a6p-7) +
                        zz * ((-0x1.a01a019c161d5p-13 + z * 0x1.71de357b1fe7dp-19) +
                              zz * (-0x1.ae5e68a2b9cebp-26 + z * 0x1.5d93a5acfd57cp-33));
    const lanes cosines = (0x1.555555555554cp-5 + z * -0x1.6c16c16c15177p-10) +
                          zz * ((0x1.a01a019cb159p-16 + z * -0x1.27e4f809c52adp-22) +
                                zz * (0x1.1ee9ebdb4b1c4p-29 + z * -0x1.8fae9be8838d4p-37));
    const lane_bits sine = LANE_BITS(r + (r * (z * sines) + low));
    const lane_bits cosine = LANE_BITS(whole + (((1 - whole) - half) + (zz * cosines - r * low)));
    const lane_bits swap = (sine ^ cosine) & -(quadrant & 1);
    STORE_LANES(s, BITS_LANES(sine ^ swap ^ ((given ^ -(quadrant & 2)) & INT64_MIN)));
    STORE_LANES(c, BITS_LANES(cosine ^ swap ^ (-((quadrant + 1) & 2) & INT64_MIN)));
}

#endif
