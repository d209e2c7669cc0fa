/* Householder QR of rows that come one block at a time. */
#include <float.h>
#include <math.h>

#include "math/dense.h"
#include "math/four.h"

enum { WIDE = 8 }; /* columns that are worked on at once */

/* The reflector 1 - tau (1; v) (1; v)' below a row: v[m] has the row stride `ld`. */
typedef struct {
    const double *v;
    int ld, m;
    double tau;
} reflection;

/* Reflect the columns t[c] (the row), A[m][c] (what lies below), c < columns <= WIDE. */
MUKCA_INLINE void reflect(double *t, double *A, const reflection *h, int columns)
{
    const double *v = h->v;
    const long ld = h->ld;
    double w[WIDE] = {0};
    for (int c = 0; c < columns; c++) w[c] = t[c];
    for (int r = 0; r < h->m; r++)
        for (int c = 0; c < columns; c++) w[c] += v[r * ld] * A[r * ld + c];
    for (int c = 0; c < columns; c++) t[c] -= w[c] *= h->tau;
    for (int r = 0; r < h->m; r++)
        for (int c = 0; c < columns; c++) A[r * ld + c] -= v[r * ld] * w[c];
}

/* The same on any number of columns. */
MUKCA_INLINE void reflect_all(double *t, double *A, const reflection *h, int columns)
{
    int c = 0;
    for (; c + WIDE <= columns; c += WIDE) reflect(t + c, A + c, h, WIDE);
    if (c + 4 <= columns) {
        reflect(t + c, A + c, h, 4);
        c += 4;
    }
    for (; c < columns; c++) reflect(t + c, A + c, h, 1);
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
        if (h.tau != 0) reflect_all(top + 1, below + 1, &h, width - j - 1);
    }
    for (int r = 0; r < m && rss; r++)
        for (int c = 0; c < k; c++) {
            const double a = A[(long)r * width + n + c];
            rss[c] += a * a;
        }
}
