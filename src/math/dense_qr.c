/* Sequential QR by Givens rotations, row by row. */
#include <math.h>

#include "base/clones.h"
#include "math/dense.h"

MUKCA_CLONES void mukca_dense_qr_absorb(double *R, double *A, int m, int n, int k)
{
    const int width = n + k;
    for (int r = 0; r < m; r++) {
        double *restrict row = A + (long)r * width;
        for (int j = 0; j < n; j++) {
            double *restrict top = R + (long)j * width;
            if (row[j] == 0) continue;
            const double length = hypot(top[j], row[j]), c = top[j] / length, s = row[j] / length;
            for (int i = j; i < width; i++) {
                const double x = top[i], y = row[i];
                top[i] = c * x + s * y;
                row[i] = c * y - s * x;
            }
        }
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
