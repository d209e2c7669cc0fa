/* Sequential Householder QR, by blocks of rows. */
#include <float.h>
#include <math.h>

#include "math/dense.h"
#include "math/four.h"

/* x' y over m rows, both with the row stride `ld`; four sums in parallel. */
MUKCA_INLINE double column_product(const double *x, const double *y, long ld, int m)
{
    double sum[4] = {0, 0, 0, 0};
    int r = 0;
    for (; r + 4 <= m; r += 4)
        for (int i = 0; i < 4; i++) sum[i] += x[(r + i) * ld] * y[(r + i) * ld];
    for (; r < m; r++) sum[0] += x[r * ld] * y[r * ld];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* The reflector 1 - tau (1; v) (1; v)' below a row: v[m] has the row stride `ld`. */
typedef struct {
    const double *v;
    int ld, m;
    double tau;
} reflection;

/* Reflect 4 n columns, n <= 4: t[c] (the row), A[m][c] (the rows below). */
MUKCA_INLINE void reflect_fours(double *t, double *A, const reflection *h, int n)
{
    const double *v = h->v;
    const long ld = h->ld;
    four w[4];
    for (int c = 0; c < n; c++) w[c] = LOAD4(t + 4 * c);
    for (int r = 0; r < h->m; r++)
        for (int c = 0; c < n; c++) w[c] += v[r * ld] * LOAD4(A + r * ld + 4 * c);
    for (int c = 0; c < n; c++) STORE4(t + 4 * c, LOAD4(t + 4 * c) - (w[c] *= h->tau));
    for (int r = 0; r < h->m; r++) {
        const double f = v[r * ld];
        for (int c = 0; c < n; c++)
            STORE4(A + r * ld + 4 * c, LOAD4(A + r * ld + 4 * c) - f * w[c]);
    }
}

/* The same for one column. */
MUKCA_INLINE void reflect_one(double *t, double *A, const reflection *h)
{
    const double *v = h->v;
    const long ld = h->ld;
    const double w = h->tau * (*t + column_product(v, A, ld, h->m));
    *t -= w;
    for (int r = 0; r < h->m; r++) A[r * ld] -= v[r * ld] * w;
}

/* The same for any number of columns. */
MUKCA_INLINE void reflect(double *t, double *A, const reflection *h, int columns)
{
    int c = 0;
    for (; c + 16 <= columns; c += 16) reflect_fours(t + c, A + c, h, 4);
    for (; c + 4 <= columns; c += 4) reflect_fours(t + c, A + c, h, 1);
    for (; c < columns; c++) reflect_one(t + c, A + c, h);
}

/* Two reflectors in sequence, g below row t[], h below the following row `next`, on 4 n columns,
 * n <= 4: half as many reads and writes of each column.  `across`: v_h' v_g. */
MUKCA_INLINE void reflect_pair_fours(double *t, double *next, double *A, const reflection *g,
                                     const reflection *h, double across, int n)
{
    const double *a = g->v, *b = h->v;
    const long ld = g->ld;
    four w[4], z[4];
    for (int c = 0; c < n; c++) w[c] = LOAD4(t + 4 * c), z[c] = LOAD4(next + 4 * c);
    for (int r = 0; r < g->m; r++)
        for (int c = 0; c < n; c++) {
            const four x = LOAD4(A + r * ld + 4 * c);
            w[c] += a[r * ld] * x;
            z[c] += b[r * ld] * x;
        }
    for (int c = 0; c < n; c++) {
        STORE4(t + 4 * c, LOAD4(t + 4 * c) - (w[c] *= g->tau));
        z[c] = h->tau * (z[c] - across * w[c]);
        STORE4(next + 4 * c, LOAD4(next + 4 * c) - z[c]);
    }
    for (int r = 0; r < g->m; r++)
        for (int c = 0; c < n; c++)
            STORE4(A + r * ld + 4 * c,
                   (LOAD4(A + r * ld + 4 * c) - a[r * ld] * w[c]) - b[r * ld] * z[c]);
}

/* Scale (alpha; x) to a largest entry of 1; returns the previous largest entry, 0 if it is zero or
 * not finite.  For columns whose squares would underflow or overflow. */
static double normalise(double *alpha, double *x, int ldx, int m)
{
    double largest = fabs(*alpha);
    for (int r = 0; r < m; r++) largest = fmax(largest, fabs(x[(long)r * ldx]));
    if (!(largest >= DBL_MIN) || isinf(largest)) return 0;
    *alpha /= largest;
    for (int r = 0; r < m; r++) x[(long)r * ldx] /= largest;
    return largest;
}

/* Reflector that maps (alpha; x) to (*alpha; 0): x[m] (stride ldx) becomes v.  Returns tau, 0 if x
 * is already zero. */
MUKCA_INLINE double reflector(double *alpha, double *x, int ldx, int m)
{
    double sum = column_product(x, x, ldx, m), unit = 1;
    if (sum == 0 && *alpha != 0) return 0;
    if (!(sum > 1e-280 && sum < 1e280)) {
        unit = normalise(alpha, x, ldx, m);
        if (unit == 0) return 0;
        sum = column_product(x, x, ldx, m);
        if (sum < 1e-280) { /* negligible next to alpha */
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

/* Reflectors for columns j and j + 1, applied to the later columns; the first also to j + 1. */
MUKCA_INLINE void absorb_pair(double *R, double *A, int j, int m, int width)
{
    double *top = R + (long)j * width + j, *next = top + width, *below = A + j;
    const reflection g = {.v = below, .ld = width, .m = m, .tau = reflector(top, below, width, m)};
    if (g.tau != 0) reflect_one(top + 1, below + 1, &g);
    const reflection h = {
        .v = below + 1, .ld = width, .m = m, .tau = reflector(next + 1, below + 1, width, m)};
    const int columns = width - j - 2;
    int c = 0;
    if (g.tau != 0 && h.tau != 0) {
        const double across = column_product(g.v, h.v, width, m);
        for (; c + 12 <= columns; c += 12)
            reflect_pair_fours(top + 2 + c, next + 2 + c, below + 2 + c, &g, &h, across, 3);
        for (; c + 4 <= columns; c += 4)
            reflect_pair_fours(top + 2 + c, next + 2 + c, below + 2 + c, &g, &h, across, 1);
    }
    if (g.tau != 0) reflect(top + 2 + c, below + 2 + c, &g, columns - c);
    if (h.tau != 0) reflect(next + 2 + c, below + 2 + c, &h, columns - c);
}

MUKCA_CLONES void mukca_dense_qr_absorb(double *R, double *rss, double *A, int m, int n, int k)
{
    const int width = n + k;
    int j = 0;
    for (; j + 2 <= n; j += 2) absorb_pair(R, A, j, m, width);
    if (j < n) {
        double *top = R + (long)j * width + j, *below = A + j;
        const reflection h = {
            .v = below, .ld = width, .m = m, .tau = reflector(top, below, width, m)};
        if (h.tau != 0) reflect(top + 1, below + 1, &h, width - j - 1);
    }
    for (int r = 0; r < m && rss; r++)
        for (int c = 0; c < k; c++) {
            const double a = A[(long)r * width + n + c];
            rss[c] += a * a;
        }
}

void mukca_dense_qr_solve(double *x, const double *R, int n)
{
    for (int i = n - 1; i >= 0; i--) {
        const double *row = R + i * (n + 1);
        x[i] = row[n];
        for (int k = i + 1; k < n; k++) x[i] -= row[k] * x[k];
        x[i] = fabs(row[i]) > 0 ? x[i] / row[i] : 0;
    }
}
