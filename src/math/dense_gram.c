/* Products X'X and X'Y, and the Cholesky factorisation with its triangular solves. */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "math/dense.h"
#include "math/four.h"

enum { STRIP = 64 }; /* rows per pass: 60 columns of them are 30 kB */

#define ADD8(c, lo, hi)                         \
    do {                                        \
        STORE4(c, LOAD4(c) + (lo));             \
        STORE4((c) + 4, LOAD4((c) + 4) + (hi)); \
    } while (0)

/* C[4][8] += A' B for A[m][4], B[m][8] (row strides ld): eight accumulators live in registers. */
MUKCA_INLINE void gram4x8(double *C, int ldc, mukca_columns a, mukca_columns b, int m)
{
    const double *A = a.x, *B = b.x;
    four s00 = {0}, s01 = {0}, s10 = {0}, s11 = {0}, s20 = {0}, s21 = {0}, s30 = {0}, s31 = {0};
    for (int r = 0; r < m; r++, A += a.ld, B += b.ld) {
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

MUKCA_INLINE mukca_columns from(mukca_columns X, int column)
{
    return (mukca_columns){X.x + column, X.n - column, X.ld};
}

/* `width` columns of a strip, of which the last ones may be missing: those of a copy are 0. */
MUKCA_INLINE mukca_columns block_of(double *copy, mukca_columns X, int column, int width, int m)
{
    const mukca_columns there = from(X, column);
    if (there.n >= width) return there;
    memset(copy, 0, sizeof *copy * (size_t)(width * m));
    for (long r = 0; r < m; r++)
        for (int c = 0; c < there.n; c++) copy[r * width + c] = there.x[r * X.ld + c];
    return (mukca_columns){copy, there.n, width};
}

/* C += a' b for a block that may lack columns. */
MUKCA_INLINE void gram_block(double *C, int ldc, mukca_columns a, mukca_columns b, int m)
{
    if (a.n >= 4 && b.n >= 8) {
        gram4x8(C, ldc, a, b, m);
        return;
    }
    double block[32] = {0};
    gram4x8(block, 8, a, b, m);
    for (long i = 0; i < a.n && i < 4; i++)
        for (int j = 0; j < b.n && j < 8; j++) C[i * ldc + j] += block[8 * i + j];
}

/* So few products that filling a block up would cost more. */
enum { FEW = 4 };

MUKCA_INLINE void gram_few(double *C, mukca_columns X, mukca_columns Y, int m)
{
    for (int i = 0; i < X.n; i++)
        for (int j = 0; j < Y.n; j++) {
            double s = 0;
            for (long r = 0; r < m; r++) s += X.x[r * X.ld + i] * Y.x[r * Y.ld + j];
            C[i * Y.n + j] += s;
        }
}

/* C[X.n][Y.n] += X' Y of one strip of rows.  With `upper` only blocks that touch the upper triangle
 * (X and Y the same). */
MUKCA_INLINE void gram_strip(double *C, mukca_columns X, mukca_columns Y, int m, bool upper)
{
    double last_of_x[4 * STRIP], last_of_y[8 * STRIP];
    const int n = X.n, k = Y.n, n4 = n & ~3;
    const mukca_columns last = block_of(last_of_x, X, n4, 4, m);
    for (int j = 0; j < k; j += 8) {
        const mukca_columns b = block_of(last_of_y, Y, j, 8, m);
        for (int i = 0; i < n && (!upper || i < j + 8); i += 4)
            gram_block(C + (long)i * k + j, k, i < n4 ? from(X, i) : last, b, m);
    }
}

/* All strips: a strip stays in the first cache while it is used. */
MUKCA_INLINE void gram(double *C, mukca_columns X, mukca_columns Y, int m, bool upper)
{
    for (int r = 0; r < m; r += STRIP) {
        const int rows = m - r < STRIP ? m - r : STRIP;
        if (X.n * Y.n <= FEW)
            gram_few(C, X, Y, rows);
        else
            gram_strip(C, X, Y, rows, upper);
        X.x += (long)STRIP * X.ld;
        Y.x += (long)STRIP * Y.ld;
    }
}

MUKCA_CLONES void mukca_dense_symmetric(double *C, mukca_columns X, mukca_columns Y, int m)
{
    const int n = X.n;
    gram(C, X, Y, m, true);
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++) C[(long)i * n + j] = C[(long)j * n + i];
}

void mukca_dense_syrk(double *C, int n, const double *X, int m, int ldx)
{
    const mukca_columns x = {X, n, ldx};
    mukca_dense_symmetric(C, x, x, m);
}

MUKCA_CLONES void mukca_dense_xty(double *C, mukca_columns X, mukca_columns Y, int m)
{
    gram(C, X, Y, m, false);
}

/* Solve L x = b for eight right-hand sides b[n][8], `ld` apart: four rows at a time keep their sums
 * in registers. */
MUKCA_INLINE void forward8(double *b, int ld, const double *L, int ldl, int n)
{
    for (int i = 0; i < n; i += 4) {
        const int rows = n - i < 4 ? n - i : 4;
        const double *l[4];
        four x[4][2];
        for (int r = 0; r < 4; r++) { /* a row that is not there does the last one again */
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

enum { WIDEST = 512 }; /* columns left of a block of rows that is factored at once: 32 kB */

/* Columns [0, i) of the factor's rows i to i + 7, and what they take from the eight columns behind:
 * a forward substitution with the rows as right-hand sides. */
MUKCA_INLINE void eight_rows(double *A, int i, int n)
{
    double b[8 * WIDEST], block[64] = {0};
    double *row = A + (long)i * n;
    for (int r = 0; r < 8; r++)
        for (int j = 0; j < i; j++) b[8 * j + r] = row[(long)r * n + j];
    forward8(b, 8, A, n, i);
    const mukca_columns x = {b, 8, 8};
    gram4x8(block, 8, x, x, i);
    gram4x8(block + 32, 8, from(x, 4), x, i);
    for (int r = 0; r < 8; r++) {
        for (int j = 0; j < i; j++) row[(long)r * n + j] = b[8 * j + r];
        for (int j = 0; j <= r; j++) row[(long)r * n + i + j] -= block[8 * r + j];
    }
}

MUKCA_CLONES int mukca_dense_cholesky(double *A, int n)
{
    int done = 0; /* columns that the row's block has taken already */
    for (int i = 0; i < n; i++) {
        double *row = A + (long)i * n;
        if (i % 8 == 0) {
            done = i + 8 <= n && i <= WIDEST ? i : 0;
            if (done) eight_rows(A, i, n);
        }
        for (int j = done; j < i; j++) {
            const double *other = A + (long)j * n;
            row[j] = (row[j] - dot4(row + done, other + done, j - done)) / other[j];
        }
        double pivot = row[i] - dot4(row + done, row + done, i - done);
        if (!(pivot > 0) || isinf(pivot)) return 1 + i;
        row[i] = sqrt(pivot);
    }
    return 0;
}

MUKCA_CLONES void mukca_dense_forward8(double *b, int k, int ld, const double *L, int n)
{
    for (int done = 0; done < k; done += 8) forward8(b + done, ld, L, n, n);
}

MUKCA_CLONES void mukca_dense_forward(double *b, int k, const double *L, int n)
{
    int done = 0;
    for (; done + 8 <= k; done += 8) forward8(b + done, k, L, n, n);
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
