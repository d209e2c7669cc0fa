/* Singular values by one-sided Jacobi, and sparse bases of null spaces.
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

/* Columns of a matrix: `length` entries at stride `step`, columns at stride `next`; NULL: none. */
typedef struct {
    double *x;
    long next, step;
    int length;
} columns;

MUKCA_INLINE void swap_columns(columns A, int p, int q)
{
    if (A.x) swap(A.x + p * A.next, A.x + q * A.next, A.step, A.length);
}

/* Move s and the columns of A and V into descending order of s. */
MUKCA_INLINE void sort_columns(double *s, columns A, columns V, int n)
{
    for (int i = 0; i < n; i++) {
        int best = i;
        for (int j = i + 1; j < n; j++)
            if (s[j] > s[best]) best = j;
        if (best == i) continue;
        swap(s + i, s + best, 1, 1);
        swap_columns(A, i, best);
        swap_columns(V, i, best);
    }
}

/* Orthogonalise pairs of columns of A; V is rotated with them. */
MUKCA_INLINE bool orthogonalise(columns A, columns V, int n)
{
    const double tolerance = DBL_EPSILON * sqrt(A.length);
    for (int sweep = 0; sweep < MAX_SWEEPS; sweep++) {
        bool done = true;
        for (int p = 0; p < n - 1; p++)
            for (int q = p + 1; q < n; q++) {
                double *x = A.x + p * A.next, *y = A.x + q * A.next, c, s;
                const double xx = dot(x, x, A.step, A.length), xy = dot(x, y, A.step, A.length),
                             yy = dot(y, y, A.step, A.length);
                /* A column whose square underflows counts as zero. */
                if (fabs(xy) <= tolerance * sqrt(xx) * sqrt(yy) || !(fmin(xx, yy) > 1e-290)) {
                    if (xx >= yy) continue;
                    swap_columns(A, p, q); /* larger one first: fewer sweeps, and nearly sorted */
                    swap_columns(V, p, q);
                    continue;
                }
                jacobi_angle(&c, &s, xx, xy, yy);
                rotate(x, y, A.step, A.length, c, s);
                if (V.x) rotate(V.x + p, V.x + q, V.step, n, c, s);
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

    const bool square = m == n; /* transposed for contiguous columns */
    const columns A_columns = {A, square ? n : 1, square ? 1 : n, m}, V_columns = {V, 1, n, n};
    if (square) transpose(A, n);
    const bool converged = square ? orthogonalise((columns){A, n, 1, m}, V_columns, n)
                                  : orthogonalise((columns){A, 1, n, m}, V_columns, n);
    for (int j = 0; j < n; j++) {
        double *x = A + j * A_columns.next, norm = sqrt(dot(x, x, A_columns.step, m));
        if (norm > 0)
            for (long i = 0; i < m * A_columns.step; i += A_columns.step) x[i] /= norm;
        s[j] = ldexp(norm, exponent); /* NOLINT(*NullDereference): s is never NULL */
    }
    sort_columns(s, A_columns, V_columns, n);
    if (square) transpose(A, n);
    return converged ? 0 : 1;
}

void mukca_dense_reduce(double *N, int k, int n, int ld)
{
    for (int step = 0; step < k; step++) {
        double *top = N + (long)step * ld;
        int row = step, column = 0;
        for (int r = step; r < k; r++) /* pivot columns are 0 in these rows */
            for (int c = 0; c < n; c++)
                if (fabs(N[(long)r * ld + c]) > fabs(N[(long)row * ld + column]))
                    row = r, column = c;
        swap(top, N + (long)row * ld, 1, n);
        const double pivot = top[column];
        if (pivot == 0) return;
        for (int c = 0; c < n; c++) top[c] /= pivot;
        for (int r = 0; r < k; r++) {
            double *other = N + (long)r * ld, f = other[column];
            for (int c = 0; c < n && r != step; c++) other[c] -= f * top[c];
        }
    }
}
