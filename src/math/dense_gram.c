/* Products X'X and X'Y, and blocks of eight rows or columns of the Cholesky factorisation and its
 * triangular solves.  The Makefile compiles this file with contraction (base/clones.h). */
#include <math.h>
#include <stdbool.h>

#include "math/dense.h"
#include "math/four.h"

/* Rows per pass: of a wide matrix, its panels stay in the first-level cache, and the sums are
 * written rarely. */
enum { STRIP = 64 };

/* C[n][8] += A' B for A[m][n], B[m][8], n <= 4: 2 n accumulators of four. */
MUKCA_INLINE void tile4(double *C, int ldc, mukca_columns a, mukca_columns b, int m, int n)
{
    four s[4][2] = {{{0}}};
    for (int r = 0; r < m; r++, a.x += a.ld, b.x += b.ld) {
        const four lo = LOAD4(b.x), hi = LOAD4(b.x + 4);
        for (int i = 0; i < n; i++) s[i][0] += a.x[i] * lo, s[i][1] += a.x[i] * hi;
    }
    for (int i = 0; i < n; i++, C += ldc) {
        STORE4(C, LOAD4(C) + s[i][0]);
        STORE4(C + 4, LOAD4(C + 4) + s[i][1]);
    }
}

/* C[n][8 w] += A' B for A[m][n], B[m][8 w], n <= 8: n w accumulators of eight. */
MUKCA_INLINE void tile8(double *C, int ldc, mukca_columns a, mukca_columns b, int m, int n, int w)
{
    eight s[8][2] = {{{0}}};
    for (int r = 0; r < m; r++, a.x += a.ld, b.x += b.ld)
        for (int v = 0; v < w; v++) {
            const eight y = LOAD8(b.x + 8 * v);
            for (int i = 0; i < n; i++) s[i][v] += a.x[i] * y;
        }
    for (int i = 0; i < n; i++, C += ldc)
        for (int v = 0; v < w; v++) STORE8(C + 8 * v, LOAD8(C + 8 * v) + s[i][v]);
}

/* The number of rows is a constant of the kernel. */
#define ROWS(k)                                      \
    case k:                                          \
        if (w)                                       \
            tile8(C, ldc, a, b, m, k, w);            \
        else                                         \
            tile4(C, ldc, a, b, m, 1 + ((k)-1) % 4); \
        break

/* The same for n <= 8; w = 0: 8 columns in registers of four. */
MUKCA_INLINE void panel(double *C, int ldc, mukca_columns a, mukca_columns b, int m, int w)
{
    if (!w && a.n > 4) {
        tile4(C, ldc, a, b, m, 4);
        C += 4 * (long)ldc, a.x += 4, a.n -= 4;
    }
    switch (a.n) {
        ROWS(1);
        ROWS(2);
        ROWS(3);
        ROWS(4);
        ROWS(5);
        ROWS(6);
        ROWS(7);
        ROWS(8);
    }
}

/* Columns from `column` on, at most `most`. */
MUKCA_INLINE mukca_columns from(mukca_columns X, int column, int most)
{
    const int left = X.n - column;
    return (mukca_columns){X.x + column, left < most ? left : most, X.ld};
}

/* The last k <= 7 columns of C, transposed: of panels of eight columns of X.  Of the last panel,
 * lanes beyond the last column are ignored; in the last rows they would be outside of X. */
MUKCA_INLINE void gram_rest(double *C, int ldc, mukca_columns X, mukca_columns Y, int m, bool wide)
{
    for (int i = 0; i < X.n; i += 8) {
        const mukca_columns x = from(X, i, 8);
        const long last = (long)(m - 1) * x.ld + x.n - 8;
        const int inside = x.n == 8 ? m : last < 0 ? 0 : (int)(last / x.ld) + 1;
        double block[64] = {0}, row[8] = {0};
        panel(block, 8, Y, x, inside, wide);
        for (long r = inside; r < m; r++) {
            for (int c = 0; c < x.n; c++) row[c] = x.x[r * x.ld + c];
            panel(block, 8, (mukca_columns){Y.x + r * Y.ld, Y.n, Y.ld}, (mukca_columns){row, 8, 8},
                  1, wide);
        }
        for (int c = 0; c < x.n; c++)
            for (int j = 0; j < Y.n; j++) C[(long)(i + c) * ldc + j] += block[8 * j + c];
    }
}

/* C[X.n][Y.n] += X' Y, row stride of C: ldc; `upper`: only blocks with entries of the upper
 * triangle (symmetric product). */
MUKCA_INLINE void gram_any(double *C, int ldc, mukca_columns X, mukca_columns Y, int m, bool upper,
                           bool wide)
{
    const int k8 = Y.n & ~7, k16 = wide ? k8 & ~15 : 0;
    for (int r = 0; r < m; r += STRIP) {
        const int rows = m - r < STRIP ? m - r : STRIP;
        for (int j = 0; j < k16; j += 16)
            for (int i = 0; i < X.n && (!upper || i < j + 16); i += 8)
                panel(C + (long)i * ldc + j, ldc, from(X, i, 8), from(Y, j, 16), rows, 2);
        for (int j = k16; j < k8; j += 8)
            for (int i = 0; i < X.n && (!upper || i <= j); i += 8)
                panel(C + (long)i * ldc + j, ldc, from(X, i, 8), from(Y, j, 8), rows, wide);
        if (k8 < Y.n) gram_rest(C + k8, ldc, X, from(Y, k8, 8), rows, wide);
        X.x += (long)STRIP * X.ld;
        Y.x += (long)STRIP * Y.ld;
    }
}

MUKCA_KERNEL(static, gram,
             (double *C, int ldc, mukca_columns X, mukca_columns Y, int m, bool upper), C, ldc, X,
             Y, m, upper)

void mukca_dense_symmetric(double *C, mukca_columns X, mukca_columns Y, int m)
{
    const int n = X.n;
    gram(C, n, X, Y, m, true);
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++) C[(long)i * n + j] = C[(long)j * n + i];
}

void mukca_dense_syrk(double *C, int n, const double *X, int m, int ldx)
{
    const mukca_columns x = {X, n, ldx};
    mukca_dense_symmetric(C, x, x, m);
}

void mukca_dense_xty_part(double *C, int ldc, mukca_columns X, mukca_columns Y, int m)
{
    gram(C, ldc, X, Y, m, false);
}

void mukca_dense_xty(double *C, mukca_columns X, mukca_columns Y, int m)
{
    mukca_dense_xty_part(C, Y.n, X, Y, m);
}

/* Solve L x = b for eight right-hand sides b[n][8], row stride `ld`: eight rows at a time, with
 * sums in registers. */
MUKCA_INLINE void forward_by_eight(double *b, int ld, const double *L, int ldl, int n)
{
    for (int i = 0; i < n; i += 8) {
        const int rows = n - i < 8 ? n - i : 8;
        const double *l[8];
        eight x[8];
        for (int r = 0; r < 8; r++) { /* beyond the last row: the last row again */
            const int row = i + (r < rows ? r : rows - 1);
            l[r] = L + (long)row * ldl;
            x[r] = LOAD8(b + (long)row * ld);
        }
        for (int j = 0; j < i; j++) {
            const eight y = LOAD8(b + (long)j * ld);
            for (int r = 0; r < 8; r++) x[r] -= l[r][j] * y;
        }
        for (int r = 0; r < rows; r++) {
            for (int j = 0; j < r; j++) x[r] -= l[r][i + j] * x[j];
            x[r] /= l[r][i + r];
            STORE8(b + (long)(i + r) * ld, x[r]);
        }
    }
}

/* The same in registers of four doubles: four rows at a time. */
MUKCA_INLINE void forward_by_four(double *b, int ld, const double *L, int ldl, int n)
{
    for (int i = 0; i < n; i += 4) {
        const int rows = n - i < 4 ? n - i : 4;
        const double *l[4];
        four x[4][2];
        for (int r = 0; r < 4; r++) {
            const int row = i + (r < rows ? r : rows - 1);
            l[r] = L + (long)row * ldl;
            x[r][0] = LOAD4(b + (long)row * ld), x[r][1] = LOAD4(b + (long)row * ld + 4);
        }
        const double *bj = b;
        for (int j = 0; j < i; j++, bj += ld) {
            const four lo = LOAD4(bj), hi = LOAD4(bj + 4);
            for (int r = 0; r < 4; r++) x[r][0] -= l[r][j] * lo, x[r][1] -= l[r][j] * hi;
        }
        for (int r = 0; r < rows; r++) {
            for (int j = 0; j < r; j++)
                x[r][0] -= l[r][i + j] * x[j][0], x[r][1] -= l[r][i + j] * x[j][1];
            x[r][0] /= l[r][i + r], x[r][1] /= l[r][i + r];
            STORE4(b + (long)(i + r) * ld, x[r][0]);
            STORE4(b + (long)(i + r) * ld + 4, x[r][1]);
        }
    }
}

MUKCA_INLINE void mukca_dense_forward_part_any(double *b, int ld, const double *L, int ldl, int n,
                                               bool wide)
{
    if (wide)
        forward_by_eight(b, ld, L, ldl, n);
    else
        forward_by_four(b, ld, L, ldl, n);
}

MUKCA_INLINE void mukca_dense_eight_rows_any(double *A, int i, int n, bool wide)
{
    double b[8 * MUKCA_DENSE_WIDEST], block[64] = {0};
    double *row = A + (long)i * n;
    for (int r = 0; r < 8; r++)
        for (int j = 0; j < i; j++) b[8 * j + r] = row[(long)r * n + j];
    mukca_dense_forward_part_any(b, 8, A, n, i, wide);
    panel(block, 8, (mukca_columns){b, 8, 8}, (mukca_columns){b, 8, 8}, i, wide);
    for (int r = 0; r < 8; r++) {
        for (int j = 0; j < i; j++) row[(long)r * n + j] = b[8 * j + r];
        for (int j = 0; j <= r; j++) row[(long)r * n + i + j] -= block[8 * r + j];
    }
}

MUKCA_KERNEL(, mukca_dense_forward_part, (double *b, int ld, const double *L, int ldl, int n), b,
             ld, L, ldl, n)
MUKCA_KERNEL(, mukca_dense_eight_rows, (double *A, int i, int n), A, i, n)

void mukca_dense_forward8(double *b, int k, int ld, const double *L, int n)
{
    for (int done = 0; done < k; done += 8) mukca_dense_forward_part(b + done, ld, L, n, n);
}
