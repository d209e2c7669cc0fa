/* Cholesky factorisation with its triangular solves.  Up to seven rows and right-hand sides, all
 * processors compute the same bits: postures of a simulation depend on them. */
#include <math.h>

#include "math/dense.h"
#include "math/four.h"

MUKCA_CLONES bool mukca_dense_cholesky(double *A, int n)
{
    int done = 0; /* columns computed by mukca_dense_eight_rows() */
    for (int i = 0; i < n; i++) {
        double *row = A + (long)i * n;
        if (i % 8 == 0) {
            done = i + 8 <= n && i <= MUKCA_DENSE_WIDEST ? i : 0;
            if (done) mukca_dense_eight_rows(A, i, n);
        }
        for (int j = done; j < i; j++) {
            const double *other = A + (long)j * n;
            row[j] = (row[j] - dot4(row + done, other + done, j - done)) / other[j];
        }
        double pivot = row[i] - dot4(row + done, row + done, i - done);
        if (!(pivot > 0) || isinf(pivot)) return false;
        row[i] = sqrt(pivot);
    }
    return true;
}

MUKCA_CLONES void mukca_dense_forward(double *b, int k, const double *L, int n)
{
    int done = 0;
    for (; done + 8 <= k; done += 8) mukca_dense_forward_part(b + done, k, L, n, n);
    for (int i = 0; i < n && done < k; i++) {
        const double *row = L + (long)i * n;
        double *bi = b + (long)i * k;
        if (k == 1) {
            bi[0] = (bi[0] - dot4(row, b, i)) / row[i];
            continue;
        }
        for (int j = 0; j < i; j++) {
            const double *bj = b + (long)j * k;
            for (int c = done; c < k; c++) bi[c] -= row[j] * bj[c];
        }
        for (int c = done; c < k; c++) bi[c] /= row[i];
    }
}

MUKCA_CLONES void mukca_dense_backward(double *b, int k, const double *L, int n)
{
    for (int i = n - 1; i >= 0; i--) {
        const double *row = L + (long)i * n;
        const double *bi = b + (long)i * k;
        for (int c = 0; c < k; c++) b[(long)i * k + c] /= row[i];
        if (k == 1) {
            for (int j = 0; j < i; j++) b[j] -= row[j] * bi[0];
            continue;
        }
        for (int j = 0; j < i; j++) {
            double *bj = b + (long)j * k;
            for (int c = 0; c < k; c++) bj[c] -= row[j] * bi[c];
        }
    }
}

double mukca_dense_quadratic(const double *x, const double *A, int lda, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) sum += x[i] * A[(long)i * lda + k] * x[k];
    return sum;
}

double mukca_dense_variance(double *a, const double *L, int n)
{
    double sum = 0;
    mukca_dense_forward(a, 1, L, n);
    for (int i = 0; i < n; i++) sum += a[i] * a[i];
    return sum;
}

bool mukca_dense_solve(double *b, int k, double *A, int n)
{
    if (!mukca_dense_cholesky(A, n)) return false;
    mukca_dense_forward(b, k, A, n);
    mukca_dense_backward(b, k, A, n);
    return true;
}
