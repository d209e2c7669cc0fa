/* Singular values by one-sided Jacobi, projections, and sparse bases of null spaces.
 *
 * One-sided Jacobi (Demmel and Veselic 1992) computes small singular values with high
 * relative accuracy if column scaling permits, unlike bidiagonalisation.
 */
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "math/dense.h"
#include "math/four.h"

enum { MAX_SWEEPS = 60 };

/* cos and sin of the rotation that diagonalises [app apq; apq aqq]. */
static void jacobi_angle(double *c, double *s, double app, double apq, double aqq)
{
    double zeta = (aqq - app) / (2 * apq);
    double t = copysign(1, zeta) / (fabs(zeta) + hypot(1, zeta));
    *c = 1 / sqrt(1 + t * t);
    *s = *c * t;
}

/* (x, y) := (c x - s y, s x + c y) for n entries at stride `step`. */
MUKCA_INLINE void rotate(double *x, double *y, long step, int n, double c, double s)
{
    for (long i = 0; i < n * step; i += step) {
        double a = x[i], b = y[i];
        x[i] = c * a - s * b;
        y[i] = s * a + c * b;
    }
}

static void swap(double *x, double *y, long step, int n)
{
    for (long i = 0; i < n * step; i += step) {
        double a = x[i];
        x[i] = y[i];
        y[i] = a;
    }
}

static void transpose(double *A, int n)
{
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++) {
            double a = A[(long)i * n + j];
            A[(long)i * n + j] = A[(long)j * n + i];
            A[(long)j * n + i] = a;
        }
}

/* Largest absolute entry; NaN if any entry is NaN. */
static double largest(const double *A, long count)
{
    double max = 0;
    for (long i = 0; i < count; i++) {
        if (A[i] != A[i]) return A[i];
        if (fabs(A[i]) > max) max = fabs(A[i]);
    }
    return max;
}

/* Swap columns p and q of A, which are rows here, and of V. */
static void swap_columns(double *A, double *V, int n, int p, int q)
{
    swap(A + p * n, A + q * n, 1, n);
    swap(V + p, V + q, n, n);
}

/* Orthogonalise pairs of columns of A, which are rows here; V is rotated with them. */
MUKCA_INLINE bool orthogonalise(double *A, double *V, int n)
{
    const double tolerance = DBL_EPSILON * sqrt(n);
    for (int sweep = 0; sweep < MAX_SWEEPS; sweep++) {
        bool done = true;
        for (int p = 0; p < n - 1; p++)
            for (int q = p + 1; q < n; q++) {
                double *x = A + p * n, *y = A + q * n, c, s;
                const double xx = dot4(x, x, n), xy = dot4(x, y, n), yy = dot4(y, y, n);
                /* A column whose square underflows counts as zero. */
                if (fabs(xy) <= tolerance * sqrt(xx) * sqrt(yy) || !(fmin(xx, yy) > 1e-290)) {
                    /* larger one first: fewer sweeps, and nearly sorted */
                    if (xx < yy) swap_columns(A, V, n, p, q);
                    continue;
                }
                jacobi_angle(&c, &s, xx, xy, yy);
                rotate(x, y, 1, n, c, s);
                rotate(V + p, V + q, n, n, c, s);
                done = false;
            }
        if (done) return true;
    }
    return false;
}

MUKCA_CLONES int mukca_dense_svd(double *A, double *s, double *V, int n)
{
    double scale = largest(A, n * n);
    if (!isfinite(scale)) return 1;
    for (int i = 0; i < n * n; i++) V[i] = i % (n + 1) == 0;
    int exponent = 0;
    if (scale > 0) frexp(scale, &exponent);
    if (abs(exponent) < 300) exponent = 0; /* squares are safe */
    for (int i = 0; exponent != 0 && i < n * n; i++) A[i] = ldexp(A[i], -exponent);

    transpose(A, n); /* for contiguous columns */
    const bool converged = orthogonalise(A, V, n);
    for (int j = 0; j < n; j++) {
        double *x = A + j * n, norm = sqrt(dot4(x, x, n));
        for (int i = 0; i < n && norm > 0; i++) x[i] /= norm;
        s[j] = ldexp(norm, exponent);
    }
    for (int i = 0; i < n; i++) {
        int best = i;
        for (int j = i + 1; j < n; j++)
            if (s[j] > s[best]) best = j;
        swap(s + i, s + best, 1, 1);
        if (best != i) swap_columns(A, V, n, i, best);
    }
    transpose(A, n);
    return converged ? 0 : 1;
}

void mukca_dense_project(double *X, int rows, int w, int first, int end)
{
    for (int b = first; b < end; b++) {
        double square = 0;
        for (int i = 0; i < rows; i++) square += X[i * w + b] * X[i * w + b];
        for (int c = b + 1; c < w && square > 1e-9 * rows; c++) {
            double dot = 0;
            for (int i = 0; i < rows; i++) dot += X[i * w + b] * X[i * w + c];
            for (int i = 0; i < rows; i++) X[i * w + c] -= dot / square * X[i * w + b];
        }
    }
}
