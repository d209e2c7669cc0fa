/* Forward kinematics of many configurations at once, eight rows side by side. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "base/clones.h"
#include "mukca/chain.h"

enum { LANES = 8 };

/* Sine and cosine of eight angles; absolute error under 3e-16 for |x| < 1e5, NaN beyond.
 * Cody-Waite reduction by pi/2 and the polynomials of fdlibm's kernels; no branch, so that the
 * compiler vectorises it. */
static inline void sincos_lanes(double *s, double *c, const double *x)
{
    for (int l = 0; l < LANES; l++) {
        union {
            double d;
            uint64_t u;
        } shifted;
        shifted.d = x[l] * 0.63661977236758134308 + 0x1.8p52;
        const double n = shifted.d - 0x1.8p52;
        double r = x[l] - n * 1.57079632673412561417e+00;
        r -= n * 6.07710050630396597660e-11;
        r -= n * 2.02226624879595063154e-21;
        const double z = r * r;
        const double sine = r + r * z *
                                    (-1.66666666666666324348e-01 +
                                     z * (8.33333333332248946124e-03 +
                                          z * (-1.98412698298579493134e-04 +
                                               z * (2.75573137070700676789e-06 +
                                                    z * (-2.50507602534068634195e-08 +
                                                         z * 1.58969099521155010221e-10)))));
        const double cosine = 1 - 0.5 * z +
                              z * z *
                                  (4.16666666666666019037e-02 +
                                   z * (-1.38888888888741095749e-03 +
                                        z * (2.48015872894767294178e-05 +
                                             z * (-2.75573143513906633035e-07 +
                                                  z * (2.08757232129817482790e-09 -
                                                       z * 1.13596475577881948265e-11)))));
        const uint64_t quadrant = shifted.u & 3u;
        const double odd = (double)(quadrant & 1u);
        const double sign_s = 1.0 - (double)(quadrant & 2u);
        const double sign_c = 1.0 - (double)((quadrant + 1u) & 2u);
        const double valid = n - n; /* 0, or NaN for an infinite angle */
        s[l] = sign_s * (odd * cosine + (1 - odd) * sine) + valid;
        c[l] = sign_c * (odd * sine + (1 - odd) * cosine) + valid;
    }
}

MUKCA_CLONES static void positions_block(double (*restrict out)[LANES],
                                         const mukca_geometry *restrict geometry,
                                         const double (*restrict q)[LANES])
{
    double x[LANES] = {0}, y[LANES] = {0}, z[LANES] = {0};
    for (int k = geometry->n_elements - 1; k >= 0; k--) {
        const int j = geometry->joint[k];
        const double *a = geometry->axis[k], *R = geometry->origin[k].R, *p = geometry->origin[k].p;
        if (j >= 0 && geometry->type[k] == MUKCA_PRISMATIC) {
            for (int l = 0; l < LANES; l++) {
                x[l] += q[j][l] * a[0];
                y[l] += q[j][l] * a[1];
                z[l] += q[j][l] * a[2];
            }
        } else if (j >= 0) {
            double s[LANES], c[LANES];
            sincos_lanes(s, c, q[j]);
            if (geometry->axis_z[k]) {
                const double sign = geometry->axis_z[k];
                for (int l = 0; l < LANES; l++) {
                    const double xl = x[l], sz = sign * s[l];
                    x[l] = c[l] * xl - sz * y[l];
                    y[l] = sz * xl + c[l] * y[l];
                }
            } else {
                for (int l = 0; l < LANES; l++) {
                    const double xl = x[l], yl = y[l], zl = z[l];
                    const double along = (1 - c[l]) * (a[0] * xl + a[1] * yl + a[2] * zl);
                    x[l] = c[l] * xl + s[l] * (a[1] * zl - a[2] * yl) + along * a[0];
                    y[l] = c[l] * yl + s[l] * (a[2] * xl - a[0] * zl) + along * a[1];
                    z[l] = c[l] * zl + s[l] * (a[0] * yl - a[1] * xl) + along * a[2];
                }
            }
        }
        for (int l = 0; l < LANES; l++) {
            const double xl = x[l], yl = y[l], zl = z[l];
            x[l] = R[0] * xl + R[1] * yl + R[2] * zl + p[0];
            y[l] = R[3] * xl + R[4] * yl + R[5] * zl + p[1];
            z[l] = R[6] * xl + R[7] * yl + R[8] * zl + p[2];
        }
    }
    memcpy(out[0], x, sizeof x);
    memcpy(out[1], y, sizeof y);
    memcpy(out[2], z, sizeof z);
}

void mukca_fk_positions(double *positions, const mukca_geometry *geometry, const double *q,
                        int rows)
{
    const int n = geometry->n_joints;
    double block[MUKCA_MAX_JOINTS][LANES], out[3][LANES];
    for (int start = 0; start < rows; start += LANES) {
        const int m = rows - start < LANES ? rows - start : LANES;
        int wide = 0; /* an angle that the fast reduction does not cover */
        for (int j = 0; j < n; j++)
            for (int l = 0; l < LANES; l++) {
                const double angle = q[(start + (l < m ? l : 0)) * n + j];
                block[j][l] = angle;
                wide |= !(fabs(angle) < 1e5);
            }
        if (wide) {
            for (int l = 0; l < m; l++)
                mukca_fk_position(positions + 3 * (start + l), geometry, q + (start + l) * n, NULL);
            continue;
        }
        positions_block(out, geometry, (const double(*)[LANES])block);
        for (int l = 0; l < m; l++)
            for (int i = 0; i < 3; i++) positions[3 * (start + l) + i] = out[i][l];
    }
}
