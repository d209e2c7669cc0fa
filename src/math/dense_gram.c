/* Products X'X and X'Y, and the Cholesky factorisation with its triangular solves. */
#include <math.h>

#include "math/dense.h"
#include "math/four.h"

enum { STRIP = 64 }; /* rows per pass: a strip of some 60 columns stays in the first cache */

#define ADD8(c, lo, hi)                                     \
    do {                                                    \
        *(four *)(void *)(c) = LOAD4(c) + (lo);             \
        *(four *)(void *)((c) + 4) = LOAD4((c) + 4) + (hi); \
    } while (0)

/* C[4][8] += A' B for A[m][4], B[m][8]: eight accumulators live in registers. */
MUKCA_INLINE void gram4x8(double *C, int ldc, const double *A, int lda, const double *B, int ldb,
                          int m)
{
    four s00 = {0}, s01 = {0}, s10 = {0}, s11 = {0}, s20 = {0}, s21 = {0}, s30 = {0}, s31 = {0};
    for (int r = 0; r < m; r++, A += lda, B += ldb) {
        four b0 = LOAD4(B), b1 = LOAD4(B + 4);
        s00 += A[0] * b0;
        s01 += A[0] * b1;
        s10 += A[1] * b0;
        s11 += A[1] * b1;
        s20 += A[2] * b0;
        s21 += A[2] * b1;
        s30 += A[3] * b0;
        s31 += A[3] * b1;
    }
    ADD8(C, s00, s01);
    ADD8(C + ldc, s10, s11);
    ADD8(C + 2 * (long)ldc, s20, s21);
    ADD8(C + 3 * (long)ldc, s30, s31);
}

/* c[8 entries, `step` apart] += a' B for the column a[m] (stride lda) and B[m][8]. */
MUKCA_INLINE void gram1x8(double *c, int step, const double *a, int lda, const double *B, int ldb,
                          int m)
{
    four s0 = {0}, s1 = {0};
    for (int r = 0; r < m; r++, a += lda, B += ldb) {
        s0 += a[0] * LOAD4(B);
        s1 += a[0] * LOAD4(B + 4);
    }
    for (int i = 0; i < 4; i++) c[(long)i * step] += s0[i];
    for (int i = 0; i < 4; i++) c[(long)(4 + i) * step] += s1[i];
}

MUKCA_INLINE double gram1x1(const double *a, int lda, const double *b, int ldb, int m)
{
    double s = 0;
    for (int r = 0; r < m; r++) s += a[(long)r * lda] * b[(long)r * ldb];
    return s;
}

/* One strip of rows.  With `upper` only blocks that touch the upper triangle (X and Y the same). */
MUKCA_INLINE void gram_strip(double *C, int ldc, const double *X, int n, int ldx, const double *Y,
                             int k, int ldy, int m, int upper)
{
    int n4 = n & ~3, k8 = k & ~7, n8 = n & ~7;
    for (int i = 0; i < n4; i += 4)
        for (int j = upper ? i & ~7 : 0; j < k8; j += 8)
            gram4x8(C + (long)i * ldc + j, ldc, X + i, ldx, Y + j, ldy, m);
    for (int i = n4; i < n; i++)
        for (int j = upper ? i & ~7 : 0; j < k8; j += 8)
            gram1x8(C + (long)i * ldc + j, 1, X + i, ldx, Y + j, ldy, m);
    for (int j = k8; j < k; j++) {
        for (int i = 0; i < n8; i += 8)
            gram1x8(C + (long)i * ldc + j, ldc, Y + j, ldy, X + i, ldx, m);
        for (int i = n8; i < n; i++) C[(long)i * ldc + j] += gram1x1(X + i, ldx, Y + j, ldy, m);
    }
}

MUKCA_CLONES void mukca_dense_syrk(double *C, int n, const double *X, int m, int ldx)
{
    for (int r = 0; r < m; r += STRIP) {
        const double *x = X + (long)r * ldx;
        int rows = m - r < STRIP ? m - r : STRIP;
        gram_strip(C, n, x, n, ldx, x, n, ldx, rows, 1);
    }
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++) C[(long)i * n + j] = C[(long)j * n + i];
}

MUKCA_CLONES void mukca_dense_xty(double *C, int ldc, const double *X, int n, int ldx,
                                  const double *Y, int k, int ldy, int m)
{
    for (int r = 0; r < m; r += STRIP) {
        int rows = m - r < STRIP ? m - r : STRIP;
        gram_strip(C, ldc, X + (long)r * ldx, n, ldx, Y + (long)r * ldy, k, ldy, rows, 0);
    }
}

MUKCA_CLONES int mukca_dense_cholesky(double *A, int n)
{
    for (int i = 0; i < n; i++) {
        double *row = A + (long)i * n;
        for (int j = 0; j < i; j++) {
            const double *other = A + (long)j * n;
            row[j] = (row[j] - dot4(row, other, j)) / other[j];
        }
        double pivot = row[i] - dot4(row, row, i);
        if (!(pivot > 0) || isinf(pivot)) return 1 + i;
        row[i] = sqrt(pivot);
    }
    return 0;
}

MUKCA_CLONES void mukca_dense_forward(double *b, int k, const double *L, int n)
{
    for (int i = 0; i < n; i++) {
        const double *row = L + (long)i * n;
        double *bi = b + (long)i * k;
        if (k == 1) {
            bi[0] = (bi[0] - dot4(row, b, i)) / row[i];
            continue;
        }
        for (int j = 0; j < i; j++) {
            const double *bj = b + (long)j * k;
            for (int c = 0; c < k; c++) bi[c] -= row[j] * bj[c];
        }
        for (int c = 0; c < k; c++) bi[c] /= row[i];
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
