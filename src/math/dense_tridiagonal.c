/* Householder reduction of a symmetric matrix to tridiagonal form. */
#include <math.h>

#include "math/dense.h"
#include "math/four.h"

/* row -= ab[0] w + ab[1] v over n entries, from the diagonal on; next += contribution of the row,
 * and of the column below its diagonal, to A x. */
MUKCA_INLINE void update(double *row, const double *v, const double *w, const double ab[2],
                         const double *x, double *next, int n)
{
    const double a = ab[0], b = ab[1], own = x[0];
    four s = {0};
    row[0] -= a * w[0] + b * v[0];
    double sum = row[0] * own;
    int i = 1;
    for (; i + 4 <= n; i += 4) {
        const four r = LOAD4(row + i) - a * LOAD4(w + i) - b * LOAD4(v + i);
        STORE4(row + i, r);
        STORE4(next + i, LOAD4(next + i) + own * r);
        s += r * LOAD4(x + i);
    }
    for (; i < n; i++) {
        row[i] -= a * w[i] + b * v[i];
        next[i] += own * row[i];
        sum += row[i] * x[i];
    }
    next[0] += (s[0] + s[1]) + (s[2] + s[3]) + sum;
}

/* v[n] := Householder vector that reduces v to *left in its first entry; returns 2 / v'v, or 0 if v
 * is already reduced. */
MUKCA_INLINE double reflect(double *v, double *left, int n)
{
    const double rest = dot4(v + 1, v + 1, n - 1), norm = sqrt(v[0] * v[0] + rest);
    *left = v[0];
    if (!(rest > 0)) return 0;
    *left = v[0] > 0 ? -norm : norm;
    v[0] -= *left;
    return 1 / (norm * fabs(v[0]));
}

/* B[m][k] -= beta x x' B. */
MUKCA_INLINE void reflect_columns(double *B, const double *x, double beta, int m, int k)
{
    int c = 0;
    for (; c + 8 <= k; c += 8) { /* sums in registers */
        four lo = {0}, hi = {0};
        for (long i = 0; i < m; i++) {
            lo += x[i] * LOAD4(B + i * k + c);
            hi += x[i] * LOAD4(B + i * k + c + 4);
        }
        lo *= beta, hi *= beta;
        for (long i = 0; i < m; i++) {
            double *b = B + i * k + c;
            STORE4(b, LOAD4(b) - x[i] * lo);
            STORE4(b + 4, LOAD4(b + 4) - x[i] * hi);
        }
    }
    for (; c < k; c++) {
        double sum = 0;
        for (long i = 0; i < m; i++) sum += x[i] * B[i * k + c];
        for (long i = 0; i < m; i++) B[i * k + c] -= beta * sum * x[i];
    }
}

/* Golub and Van Loan, Matrix Computations, algorithm 8.3.1, on the upper triangle.  One pass over a
 * row applies the update of a step and multiplies by the vector of the next step; the vectors
 * remain in the upper rows. */
MUKCA_CLONES void mukca_dense_tridiagonalise(double *A, int n, double *T, double *B, int k)
{
    double *diagonal = T, *beside = T + n, *w = T + 2 * (long)n, *next = T + 3 * (long)n;
    const double *v = w; /* of the previous step, from its column on; initially 0 */
    for (int i = 0; i < n; i++) w[i] = 0;
    for (int j = 0; j < n; j++) {
        double *row = A + (long)j * n + j, *x = row + 1;
        const int m = n - j - 1;
        for (int i = 0; i <= m; i++) row[i] -= v[0] * w[i] + w[0] * v[i];
        diagonal[j] = row[0];
        beside[j] = 0;
        if (!m) break;
        const double beta = reflect(x, &beside[j], m);
        for (int i = 0; i < m; i++) next[i] = 0;
        for (int i = 0; i < m; i++) {
            const double ab[2] = {v[1 + i], w[1 + i]};
            update(row + (long)(n + 1) * (1 + i), v + 1 + i, w + 1 + i, ab, x + i, next + i, m - i);
        }
        const double own = 0.5 * beta * beta * dot4(x, next, m);
        for (int i = 0; i < m; i++) w[i] = beta > 0 ? beta * next[i] - own * x[i] : 0;
        v = x;
        if (beta > 0) reflect_columns(B + (long)(j + 1) * k, x, beta, m, k);
    }
}
