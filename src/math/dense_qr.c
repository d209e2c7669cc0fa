/* Householder QR: with column pivoting (rank revealing), and sequential for streams of rows. */
#include <float.h>
#include <math.h>

#include "math/dense.h"
#include "math/four.h"

enum { WIDE = 8 }; /* columns that are worked on at once */

/* [t; A] -= (1; v) tau (1; v)' [t; A] on the columns t[c], A[m][c] (row stride lda), c < 8. */
MUKCA_INLINE void reflect(double *t, double *A, int lda, const double *v, int ldv, double tau,
                          int m, int columns)
{
    double w[WIDE] = {0};
    for (int c = 0; c < columns; c++) w[c] = t[c];
    for (int r = 0; r < m; r++)
        for (int c = 0; c < columns; c++) w[c] += v[(long)r * ldv] * A[(long)r * lda + c];
    for (int c = 0; c < columns; c++) t[c] -= w[c] *= tau;
    for (int r = 0; r < m; r++)
        for (int c = 0; c < columns; c++) A[(long)r * lda + c] -= v[(long)r * ldv] * w[c];
}

/* The same on any number of columns. */
MUKCA_INLINE void reflect_all(double *t, double *A, int lda, const double *v, int ldv, double tau,
                              int m, int columns)
{
    int c = 0;
    for (; c + WIDE <= columns; c += WIDE) reflect(t + c, A + c, lda, v, ldv, tau, m, WIDE);
    if (c + 4 <= columns) {
        reflect(t + c, A + c, lda, v, ldv, tau, m, 4);
        c += 4;
    }
    for (; c < columns; c++) reflect(t + c, A + c, lda, v, ldv, tau, m, 1);
}

/* Bring (alpha; x) to a largest entry of 1; returns what it was.  For columns whose squares would
 * underflow or overflow: there a reflector is no reflection any more. */
static double normalise(double *alpha, double *x, int ldx, int m)
{
    double largest = fabs(*alpha);
    for (int r = 0; r < m; r++) largest = fmax(largest, fabs(x[(long)r * ldx]));
    if (!(largest >= DBL_MIN) || isinf(largest)) return 0;
    *alpha /= largest;
    for (int r = 0; r < m; r++) x[(long)r * ldx] /= largest;
    return largest;
}

/* Reflector that maps (alpha; x) to (*alpha; 0): x[m] (stride ldx) becomes v.  Returns tau, 0 where
 * x is zero already. */
MUKCA_INLINE double reflector(double *alpha, double *x, int ldx, int m)
{
    double sum = 0, unit = 1;
    for (int r = 0; r < m; r++) sum += x[(long)r * ldx] * x[(long)r * ldx];
    if (sum == 0 && *alpha != 0) return 0;
    if (!(sum > 1e-280 && sum < 1e280)) {
        unit = normalise(alpha, x, ldx, m);
        if (unit == 0) return 0;
        sum = 0;
        for (int r = 0; r < m; r++) sum += x[(long)r * ldx] * x[(long)r * ldx];
        if (sum < 1e-280) { /* beside alpha it is nothing */
            *alpha *= unit;
            return 0;
        }
    }
    double beta = -copysign(sqrt(*alpha * *alpha + sum), *alpha);
    double tau = (beta - *alpha) / beta, scale = 1 / (*alpha - beta);
    for (int r = 0; r < m; r++) x[(long)r * ldx] *= scale;
    *alpha = beta * unit;
    return tau;
}

/* Column of the largest norm among from..n-1 over rows from..m-1; *norm2 its square (NaN where any
 * entry is NaN). */
MUKCA_INLINE int largest_column(double *norm2, const double *A, int m, int n, int from)
{
    int best = from;
    *norm2 = -1;
    for (int j = from; j < n; j += WIDE) {
        int columns = n - j < WIDE ? n - j : WIDE;
        double sum[WIDE] = {0};
        for (int r = from; r < m; r++)
            for (int c = 0; c < columns; c++) {
                double a = A[(long)r * n + j + c];
                sum[c] += a * a;
            }
        for (int c = 0; c < columns; c++)
            if (sum[c] > *norm2 || sum[c] != sum[c]) {
                *norm2 = sum[c];
                best = j + c;
                if (sum[c] != sum[c]) return best;
            }
    }
    return best;
}

MUKCA_CLONES int mukca_dense_qr(double *A, double *tau, int *pivot, int m, int n, double tolerance)
{
    int steps = m < n ? m : n, rank = 0;
    double least = tolerance > 0 ? tolerance : (m > n ? m : n) * DBL_EPSILON;
    for (int j = 0; j < n; j++) pivot[j] = j;
    for (int j = 0; j < steps; j++) {
        double norm2;
        int best = largest_column(&norm2, A, m, n, j);
        if (!isfinite(norm2)) return -1;
        if (best != j) {
            int p = pivot[j];
            pivot[j] = pivot[best];
            pivot[best] = p;
            for (int r = 0; r < m; r++) {
                double a = A[(long)r * n + j];
                A[(long)r * n + j] = A[(long)r * n + best];
                A[(long)r * n + best] = a;
            }
        }
        double *top = A + (long)j * n + j;
        tau[j] = reflector(top, top + n, n, m - j - 1);
        if (tau[j] != 0)
            reflect_all(top + 1, top + n + 1, n, top + n, n, tau[j], m - j - 1, n - j - 1);
        if (fabs(*top) > least * fabs(A[0]) && rank == j) rank = j + 1;
    }
    return rank;
}

MUKCA_CLONES void mukca_dense_qr_apply(double *b, const double *A, const double *tau, int m, int n)
{
    int steps = m < n ? m : n;
    for (int j = 0; j < steps; j++) {
        if (tau[j] != 0)
            reflect(b + j, b + j + 1, 1, A + (long)(j + 1) * n + j, n, tau[j], m - j - 1, 1);
    }
}

MUKCA_CLONES void mukca_dense_qr_absorb(double *R, double *rss, double *A, int m, int n, int k)
{
    int width = n + k;
    for (int j = 0; j < n; j++) {
        double *top = R + (long)j * width + j, *below = A + j;
        double tau = reflector(top, below, width, m);
        if (tau != 0) reflect_all(top + 1, below + 1, width, below, width, tau, m, width - j - 1);
    }
    if (!rss) return;
    for (int r = 0; r < m; r++)
        for (int c = 0; c < k; c++) {
            double a = A[(long)r * width + n + c];
            rss[c] += a * a;
        }
}
