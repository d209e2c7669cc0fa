/* Kernels of a sweep: 3x3 matrices times arrays that run along the samples. */
#ifndef MUKCA_FIT_ROWS_H
#define MUKCA_FIT_ROWS_H

#include <string.h>

#include "base/clones.h"
#include "fit/sweep.h"

enum { LANES = 8 };

static const double identity[9] = MUKCA_IDENTITY;

static inline void transpose(double At[9], const double A[9])
{
    for (int i = 0; i < 9; i++) At[i] = A[3 * (i % 3) + i / 3];
}

/* B = A' M C for 3x3 matrices. */
static inline void conjugate(double B[9], const double A[9], const double M[9], const double C[9])
{
    double MC[9];
    mukca_mat3_mul(MC, M, C);
    mukca_mat3_tmul(B, A, MC);
}

/* y[3][padded] = M x (+ p), M and p the same for all rows; y may be x. */
MUKCA_INLINE void map_rows(double *y, const double M[9], const double *p, const double *x,
                           int padded)
{
    const double *xs = x, *ys = x + padded, *zs = x + 2 * padded;
    const double px = p ? p[0] : 0, py = p ? p[1] : 0, pz = p ? p[2] : 0;
    for (int i = 0; i < padded; i += LANES) {
        double a[LANES], b[LANES], c[LANES];
        for (int l = 0; l < LANES; l++) {
            a[l] = M[0] * xs[i + l] + M[1] * ys[i + l] + M[2] * zs[i + l] + px;
            b[l] = M[3] * xs[i + l] + M[4] * ys[i + l] + M[5] * zs[i + l] + py;
            c[l] = M[6] * xs[i + l] + M[7] * ys[i + l] + M[8] * zs[i + l] + pz;
        }
        memcpy(y + i, a, sizeof a);
        memcpy(y + padded + i, b, sizeof b);
        memcpy(y + 2 * padded + i, c, sizeof c);
    }
}

/* x[3][padded] := Rz(q) x with the angles of element k's joint, backwards for sign = -1. */
MUKCA_INLINE void turn_rows(double *restrict x, const mukca_sweep *sweep, int k, double sign)
{
    const int padded = sweep->padded;
    const double *restrict s = sweep->sine + sweep->joint[k] * padded;
    const double *restrict c = sweep->cosine + sweep->joint[k] * padded;
    double *restrict y = x + padded;
    for (int i = 0; i < padded; i++) {
        const double a = x[i], b = y[i], sine = sign * s[i];
        x[i] = c[i] * a - sine * b;
        y[i] = sine * a + c[i] * b;
    }
}

#endif
