/* Householder QR of rows that come one block at a time. */
#include <float.h>
#include <math.h>

#include "math/dense.h"
#include "math/four.h"

/* The reflector 1 - tau (1; v) (1; v)' below a row: v[m] has the row stride `ld`. */
typedef struct {
    const double *v;
    int ld, m;
    double tau;
} reflection;

/* Reflect 4 n columns, n <= 4: t[c] (the row), A[m][c] (what lies below). */
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
    double w = *t;
    for (int r = 0; r < h->m; r++) w += v[r * ld] * A[r * ld];
    *t -= w *= h->tau;
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

/* Scale (alpha; x) to a largest entry of 1; returns the former one, 0 where that is zero or not
 * finite.  For columns whose squares would underflow or overflow. */
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

MUKCA_CLONES void mukca_dense_qr_absorb(double *R, double *rss, double *A, int m, int n, int k)
{
    const int width = n + k;
    for (int j = 0; j < n; j++) {
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
