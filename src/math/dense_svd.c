/* Jacobi methods: singular values, symmetric eigenvalues, minimum-norm least squares.
 *
 * One-sided Jacobi (Demmel and Veselic 1992) keeps small singular values accurate to their own size
 * where column scaling allows it, which the usual bidiagonalisation does not.
 */
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "math/dense.h"
#include "math/four.h"

enum { MAX_SWEEPS = 60 };

/* cos and sin of the rotation that diagonalises [app apq; apq aqq]; returns tan. */
static double jacobi_angle(double *c, double *s, double app, double apq, double aqq)
{
    double zeta = (aqq - app) / (2 * apq);
    double t = copysign(1, zeta) / (fabs(zeta) + hypot(1, zeta));
    *c = 1 / sqrt(1 + t * t);
    *s = *c * t;
    return t;
}

MUKCA_INLINE double dot(const double *x, const double *y, long step, int n)
{
    if (step == 1) return dot4(x, y, n);
    double sum = 0;
    for (long i = 0; i < n * step; i += step) sum += x[i] * y[i];
    return sum;
}

MUKCA_INLINE void rotate(double *x, double *y, long step, int n, double c, double s)
{
    for (long i = 0; i < n * step; i += step) {
        double a = x[i], b = y[i];
        x[i] = c * a - s * b;
        y[i] = s * a + c * b;
    }
}

MUKCA_INLINE void swap(double *x, double *y, long step, int n)
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

/* Largest absolute entry; NaN where there is one. */
static double largest(const double *A, long count)
{
    double max = 0;
    for (long i = 0; i < count; i++) {
        if (A[i] != A[i]) return A[i];
        if (fabs(A[i]) > max) max = fabs(A[i]);
    }
    return max;
}

/* Move the columns (and s, V) into descending order of s. */
MUKCA_INLINE void sort_columns(double *A, long column, long step, int m, double *s, double *V,
                               int n)
{
    for (int i = 0; i < n; i++) {
        int best = i;
        for (int j = i + 1; j < n; j++)
            if (s[j] > s[best]) best = j;
        if (best == i) continue;
        swap(s + i, s + best, 1, 1);
        if (A) swap(A + i * column, A + best * column, step, m);
        if (V) swap(V + i, V + best, n, n);
    }
}

/* Orthogonalise the columns (m entries `step` apart, the next column `column` on) in pairs. */
MUKCA_INLINE bool orthogonalise(double *A, long column, long step, double *V, int m, int n)
{
    double tolerance = DBL_EPSILON * sqrt(m);
    for (int sweep = 0; sweep < MAX_SWEEPS; sweep++) {
        bool done = true;
        for (int p = 0; p < n - 1; p++)
            for (int q = p + 1; q < n; q++) {
                double *x = A + p * column, *y = A + q * column;
                double xx = dot(x, x, step, m), xy = dot(x, y, step, m), yy = dot(y, y, step, m);
                /* A column whose square underflows is zero beside the others. */
                if (fabs(xy) <= tolerance * sqrt(xx) * sqrt(yy) || !(fmin(xx, yy) > 1e-290)) {
                    if (xx >= yy) continue;
                    swap(x, y, step, m); /* the larger one first: faster, and nearly sorted */
                    if (V) swap(V + p, V + q, n, n);
                    continue;
                }
                double c, s;
                jacobi_angle(&c, &s, xx, xy, yy);
                rotate(x, y, step, m, c, s);
                if (V) rotate(V + p, V + q, n, n, c, s);
                done = false;
            }
        if (done) return true;
    }
    return false;
}

MUKCA_CLONES int mukca_dense_svd(double *A, double *s, double *V, int m, int n)
{
    double scale = largest(A, (long)m * n);
    if (!isfinite(scale)) return 1;
    if (V)
        for (int i = 0; i < n * n; i++) V[i] = i % (n + 1) == 0;
    int exponent = 0;
    if (scale > 0) frexp(scale, &exponent);
    if (abs(exponent) < 300) exponent = 0; /* squares are safe */
    for (long i = 0; exponent != 0 && i < (long)m * n; i++) A[i] = ldexp(A[i], -exponent);

    bool square = m == n, converged;
    long column = square ? n : 1, step = square ? 1 : n;
    if (square) {
        transpose(A, n); /* columns become contiguous */
        converged = orthogonalise(A, n, 1, V, m, n);
    } else {
        converged = orthogonalise(A, 1, n, V, m, n);
    }
    for (int j = 0; j < n; j++) {
        double *x = A + j * column, norm = sqrt(dot(x, x, step, m));
        if (norm > 0)
            for (long i = 0; i < m * step; i += step) x[i] /= norm;
        s[j] = ldexp(norm, exponent); /* NOLINT(*NullDereference): s is never NULL */
    }
    sort_columns(A, column, step, m, s, V, n);
    if (square) transpose(A, n);
    return converged ? 0 : 1;
}

MUKCA_CLONES int mukca_dense_eigen(double *w, double *V, double *A, int n)
{
    double scale = largest(A, (long)n * n);
    if (!isfinite(scale)) return 1;
    if (V)
        for (int i = 0; i < n * n; i++) V[i] = i % (n + 1) == 0;
    bool done = false;
    for (int sweep = 0; sweep < MAX_SWEEPS && !done; sweep++) {
        done = true;
        for (int p = 0; p < n - 1; p++)
            for (int q = p + 1; q < n; q++) {
                double apq = A[(long)p * n + q], app = A[(long)p * n + p], aqq = A[(long)q * n + q];
                if (fabs(apq) <= 0.25 * DBL_EPSILON * sqrt(fabs(app)) * sqrt(fabs(aqq)) ||
                    fabs(apq) <= DBL_EPSILON * DBL_EPSILON * scale)
                    continue;
                double c, s, t = jacobi_angle(&c, &s, app, apq, aqq);
                rotate(A + (long)p * n, A + (long)q * n, 1, n, c, s);
                rotate(A + p, A + q, n, n, c, s);
                A[(long)p * n + p] = app - t * apq; /* exact on paper, and free of drift */
                A[(long)q * n + q] = aqq + t * apq;
                A[(long)p * n + q] = A[(long)q * n + p] = 0;
                if (V) rotate(V + p, V + q, n, n, c, s);
                if (fabs(apq) > DBL_EPSILON * scale) done = false;
            }
    }
    for (int i = 0; i < n; i++) w[i] = A[(long)i * n + i];
    sort_columns(NULL, 0, 0, 0, w, V, n);
    return done ? 0 : 1;
}

/* z := diag(1/s) z with the small ones dropped; returns the rank. */
static int divide(double *z, const double *s, int n, double tolerance)
{
    int rank = 0;
    while (rank < n && s[rank] > tolerance * s[0] && s[rank] > 0) rank++;
    for (int j = 0; j < n; j++) z[j] = j < rank ? z[j] / s[j] : 0;
    return rank;
}

int mukca_dense_lstsq(double *x, double *A, double *b, int m, int n, double tolerance, double *work)
{
    if (n < 1 || !work) return 0;
    double *s = work + (long)n * n;
    if (!(tolerance > 0)) tolerance = (m > n ? m : n) * DBL_EPSILON;
    if (m < n) { /* A' = U diag(s) V', x = U diag(1/s) V' b; V fits where A was */
        for (int i = 0; i < m; i++)
            for (int j = 0; j < n; j++) work[(long)j * m + i] = A[(long)i * n + j];
        if (mukca_dense_svd(work, s, A, n, m)) return -1;
        for (int j = 0; j < m; j++) {
            x[j] = 0;
            for (int i = 0; i < m; i++) x[j] += A[(long)i * m + j] * b[i];
        }
        for (int j = 0; j < m; j++) b[j] = x[j];
        int rank = divide(b, s, m, tolerance);
        for (int i = 0; i < n; i++) {
            x[i] = 0;
            for (int j = 0; j < rank; j++) x[i] += work[(long)i * m + j] * b[j];
        }
        return rank;
    }
    if (mukca_dense_svd(A, s, work, m, n)) return -1;
    for (int j = 0; j < n; j++) {
        x[j] = 0;
        for (int i = 0; i < m; i++) x[j] += A[(long)i * n + j] * b[i];
    }
    for (int j = 0; j < n; j++) b[j] = x[j];
    int rank = divide(b, s, n, tolerance);
    for (int i = 0; i < n; i++) {
        x[i] = 0;
        for (int j = 0; j < rank; j++) x[i] += work[(long)i * n + j] * b[j];
    }
    return rank;
}
