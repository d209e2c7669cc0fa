/* Products X'X and X'Y, and blocks of eight rows or columns of the Cholesky factorisation and its
 * triangular solves.  The Makefile compiles this file with contraction (base/clones.h). */
#include <math.h>
#include <stdbool.h>

#include "math/dense.h"
#include "math/four.h"

enum { STRIP = 16 }; /* rows per pass: of a wide matrix, as many streams as processors prefetch */

#define ADD8(c, lo, hi)                         \
    do {                                        \
        STORE4(c, LOAD4(c) + (lo));             \
        STORE4((c) + 4, LOAD4((c) + 4) + (hi)); \
    } while (0)

/* C[4][8] += A' B for A[m][4], B[m][8] (row strides ld): eight accumulators in registers. */
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

/* Eight doubles, for the clone whose registers hold them. */
typedef double eight __attribute__((vector_size(64), aligned(8), may_alias));
#define LOAD8(x) (*(const eight *)(const void *)(x))

MUKCA_INLINE bool has_eight(void)
{
#ifdef MUKCA_CLONES_V4
    return __builtin_cpu_supports("avx512f");
#else
    return false;
#endif
}

/* C[4][16] += A' B: eight accumulators. */
MUKCA_INLINE void gram4x16(double *C, int ldc, mukca_columns a, mukca_columns b, int m)
{
    const double *A = a.x, *B = b.x;
    eight s[4][2] = {{{0}}};
    for (int r = 0; r < m; r++, A += a.ld, B += b.ld) {
        const eight b0 = LOAD8(B), b1 = LOAD8(B + 8);
        for (int i = 0; i < 4; i++) s[i][0] += A[i] * b0, s[i][1] += A[i] * b1;
    }
    for (int i = 0; i < 4; i++, C += ldc) {
        *(eight *)(void *)C = LOAD8(C) + s[i][0];
        *(eight *)(void *)(C + 8) = LOAD8(C + 8) + s[i][1];
    }
}

/* C[4][4] += A' B. */
MUKCA_INLINE void gram4x4(double *C, int ldc, mukca_columns a, mukca_columns b, int m)
{
    four s[4] = {{0}};
    for (int r = 0; r < m; r++, a.x += a.ld, b.x += b.ld)
        for (int i = 0; i < 4; i++) s[i] += a.x[i] * LOAD4(b.x);
    for (long i = 0; i < 4; i++) STORE4(C + i * ldc, LOAD4(C + i * ldc) + s[i]);
}

/* C[n][8] += A' B for A[m][n] and B[m][8], n < 4; strides of c: `row`, `column`. */
MUKCA_INLINE void gram_few(double *c, long row, long column, mukca_columns a, mukca_columns b,
                           int m, int n)
{
    four s[3][2] = {{{0}}};
    for (int r = 0; r < m; r++, a.x += a.ld, b.x += b.ld)
        for (int i = 0; i < n; i++) {
            s[i][0] += a.x[i] * LOAD4(b.x);
            s[i][1] += a.x[i] * LOAD4(b.x + 4);
        }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < 8; j++) c[i * row + j * column] += s[i][j / 4][j % 4];
}

/* The columns together: the additions to a single sum are sequential. */
MUKCA_INLINE void gram_rest(double *c, long row, long column, mukca_columns a, mukca_columns b,
                            int m, int n)
{
    if (n == 1) gram_few(c, row, column, a, b, m, 1);
    if (n == 2) gram_few(c, row, column, a, b, m, 2);
    if (n == 3) gram_few(c, row, column, a, b, m, 3);
}

/* Transposed, of four columns: C[8][4] += B' A for A[m][4] and B[m][8]; row stride of c: `step`. */
MUKCA_INLINE void gram4x8_turned(double *c, long step, mukca_columns a, mukca_columns b, int m)
{
    double block[32] = {0};
    gram4x8(block, 8, a, b, m);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 8; j++) c[j * step + i] += block[8 * i + j];
}

MUKCA_INLINE double gram1x1(mukca_columns a, mukca_columns b, int m)
{
    double s = 0;
    for (long r = 0; r < m; r++) s += a.x[r * a.ld] * b.x[r * b.ld];
    return s;
}

MUKCA_INLINE mukca_columns from(mukca_columns X, int column)
{
    return (mukca_columns){X.x + column, X.n - column, X.ld};
}

/* C[X.n][Y.n] += X' Y of one strip of rows, row stride of C: ldc; `upper`: only blocks with entries
 * of the upper triangle (symmetric product). */
MUKCA_INLINE void gram_strip(double *C, int ldc, mukca_columns X, mukca_columns Y, int m,
                             bool upper)
{
    const int n = X.n, k = Y.n, n4 = n & ~3, k8 = k & ~7, n8 = n & ~7;
    int wide = 0;
    for (; has_eight() && wide + 16 <= k8; wide += 16)
        for (int i = 0; i < n4 && (!upper || (i & ~7) <= wide + 8); i += 4)
            gram4x16(C + (long)i * ldc + wide, ldc, from(X, i), from(Y, wide), m);
    for (int j = wide; j < k8; j += 8) /* eight columns of Y at a time: it may be wide */
        for (int i = 0; i < n4 && (!upper || (i & ~7) <= j); i += 4)
            gram4x8(C + (long)i * ldc + j, ldc, from(X, i), from(Y, j), m);
    for (int j = upper ? n4 & ~7 : 0; j < k8 && n4 < n; j += 8)
        gram_rest(C + (long)n4 * ldc + j, ldc, 1, from(X, n4), from(Y, j), m, n - n4);
    int j4 = k8;
    if (k - k8 >= 4) {
        for (int i = 0; i < n8; i += 8)
            gram4x8_turned(C + (long)i * ldc + k8, ldc, from(Y, k8), from(X, i), m);
        if (n - n8 >= 4) gram4x4(C + (long)n8 * ldc + k8, ldc, from(X, n8), from(Y, k8), m);
        for (int i = n - n8 >= 4 ? n8 + 4 : n8; i < n; i++)
            for (int j = k8; j < k8 + 4; j++)
                C[(long)i * ldc + j] += gram1x1(from(X, i), from(Y, j), m);
        j4 += 4;
    }
    for (int i = 0; i < n8 && j4 < k; i += 8)
        gram_rest(C + (long)i * ldc + j4, 1, ldc, from(Y, j4), from(X, i), m, k - j4);
    for (int j = j4; j < k; j++)
        for (int i = n8; i < n; i++) C[(long)i * ldc + j] += gram1x1(from(X, i), from(Y, j), m);
}

/* All strips; each stays in the first-level cache while in use. */
MUKCA_INLINE void gram(double *C, int ldc, mukca_columns X, mukca_columns Y, int m, bool upper)
{
    for (int r = 0; r < m; r += STRIP) {
        gram_strip(C, ldc, X, Y, m - r < STRIP ? m - r : STRIP, upper);
        X.x += (long)STRIP * X.ld;
        Y.x += (long)STRIP * Y.ld;
    }
}

MUKCA_CLONES void mukca_dense_symmetric(double *C, mukca_columns X, mukca_columns Y, int m)
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

MUKCA_CLONES void mukca_dense_xty_part(double *C, int ldc, mukca_columns X, mukca_columns Y, int m)
{
    gram(C, ldc, X, Y, m, false);
}

void mukca_dense_xty(double *C, mukca_columns X, mukca_columns Y, int m)
{
    mukca_dense_xty_part(C, Y.n, X, Y, m);
}

/* Solve L x = b for eight right-hand sides b[n][8], row stride `ld`: four rows at a time, with sums
 * in registers. */
MUKCA_INLINE void forward8(double *b, int ld, const double *L, int ldl, int n)
{
    for (int i = 0; i < n; i += 4) {
        const int rows = n - i < 4 ? n - i : 4;
        const double *l[4];
        four x[4][2];
        for (int r = 0; r < 4; r++) { /* beyond the last row: the last row again */
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

MUKCA_CLONES void mukca_dense_eight_rows(double *A, int i, int n)
{
    double b[8 * MUKCA_DENSE_WIDEST], block[64] = {0};
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

MUKCA_CLONES void mukca_dense_forward_part(double *b, int ld, const double *L, int ldl, int n)
{
    forward8(b, ld, L, ldl, n);
}

MUKCA_CLONES void mukca_dense_forward8(double *b, int k, int ld, const double *L, int n)
{
    for (int done = 0; done < k; done += 8) forward8(b + done, ld, L, n, n);
}
