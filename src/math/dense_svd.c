/* Singular values by one-sided Jacobi, and projections.
 *
 * One-sided Jacobi (Demmel and Veselic 1992) computes small singular values with high
 * relative accuracy if column scaling permits, unlike bidiagonalisation.
 */
#include <float.h>
#include <math.h>
#include <stdbool.h>

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

/* (x, y) := (c x - s y, s x + c y). */
MUKCA_INLINE void rotate(double *x, double *y, int n, double c, double s)
{
    for (int i = 0; i < n; i++) {
        const double a = x[i], b = y[i];
        x[i] = c * a - s * b;
        y[i] = s * a + c * b;
    }
}

static void transpose(double *A, int n)
{
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++) {
            const double a = A[i * n + j];
            A[i * n + j] = A[j * n + i];
            A[j * n + i] = a;
        }
}

/* Orthogonalise pairs of columns of A, and sort them by length; V is rotated with them.  The
 * columns are rows here. */
MUKCA_INLINE bool orthogonalise(double *A, double *V, int n)
{
    const double tolerance = DBL_EPSILON * sqrt(n);
    for (int sweep = 0; sweep < MAX_SWEEPS; sweep++) {
        bool done = true;
        for (int p = 0; p < n - 1; p++)
            for (int q = p + 1; q < n; q++) {
                double *x = A + p * n, *y = A + q * n, c = 0, s = 1; /* exchanged */
                const double xx = dot4(x, x, n), xy = dot4(x, y, n), yy = dot4(y, y, n);
                /* A column whose square underflows counts as zero. */
                const bool orthogonal =
                    fabs(xy) <= tolerance * sqrt(xx) * sqrt(yy) || !(fmin(xx, yy) > 1e-290);
                if (orthogonal && xx >= yy) continue;
                if (!orthogonal) jacobi_angle(&c, &s, xx, xy, yy);
                rotate(x, y, n, c, s);
                rotate(V + p * n, V + q * n, n, c, s);
                done = false;
            }
        if (done) return true;
    }
    return false;
}

MUKCA_CLONES bool mukca_dense_svd(double *A, double *s, double *V, int n)
{
    for (int i = 0; i < n * n; i++) V[i] = i % (n + 1) == 0;
    transpose(A, n); /* for contiguous columns */
    const bool converged = orthogonalise(A, V, n);
    for (int j = 0; j < n; j++) {
        double *x = A + j * n;
        s[j] = sqrt(dot4(x, x, n));
        for (int i = 0; i < n && s[j] > 0; i++) x[i] /= s[j];
    }
    transpose(A, n);
    transpose(V, n);
    return converged;
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
