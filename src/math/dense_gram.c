/* Products X'X and X'Y, and blocks of eight rows or columns of the Cholesky factorisation and its
 * triangular solves.  The Makefile compiles this file with contraction (base/clones.h). */
#include <stdbool.h>

#include "base/kernel.h"
#include "math/dense.h"

/* Rows per pass: of a wide matrix, its panels stay in the first-level cache, and the sums are
 * written rarely. */
enum { STRIP = 64 };

/* C[n][columns] += A' B for A[m][n], B[m][columns], n <= `rows`, columns <= `registers` vectors:
 * all sums in registers. */
#define TILE(name, vector, rows, registers)                                                    \
    MUKCA_INLINE void name(double *C, int ldc, mukca_columns a, mukca_columns b, int m, int n, \
                           int columns)                                                        \
    {                                                                                          \
        enum { LANES = sizeof(vector) / sizeof(double) };                                      \
        vector s[rows][registers] = {{{0}}};                                                   \
        for (int r = 0; r < m; r++, a.x += a.ld, b.x += b.ld)                                  \
            for (int v = 0; v < columns / LANES; v++) {                                        \
                const vector y = *(const vector *)(const void *)(b.x + LANES * v);             \
                for (int i = 0; i < n; i++) s[i][v] += a.x[i] * y;                             \
            }                                                                                  \
        for (int i = 0; i < n; i++, C += ldc)                                                  \
            for (int v = 0; v < columns / LANES; v++)                                          \
                *(vector *)(void *)(C + LANES * v) += s[i][v];                                 \
    }

TILE(tile8, eight, 8, 2)
TILE(tile4, four, 4, 2)
TILE(tile2, pair, 2, 4)

/* The number of rows is a constant of the kernel. */
#define ROWS(k)                                               \
    case k:                                                   \
        if (width == 8)                                       \
            tile8(C, ldc, a, b, m, k, columns);               \
        else if (width == 4)                                  \
            tile4(C, ldc, a, b, m, 1 + ((k)-1) % 4, columns); \
        else                                                  \
            tile2(C, ldc, a, b, m, 1 + ((k)-1) % 2, columns); \
        break

/* The same for n <= 8, and 8 columns, of `width` = 8 also 16. */
MUKCA_INLINE void panel(double *C, int ldc, mukca_columns a, mukca_columns b, int m, int columns,
                        int width)
{
    for (; a.n > width; C += width * (long)ldc, a.x += width, a.n -= width)
        if (width == 4)
            tile4(C, ldc, a, b, m, 4, columns);
        else
            tile2(C, ldc, a, b, m, 2, columns);
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
 * width beyond the last column are ignored; in the last rows they would be outside of X. */
MUKCA_INLINE void gram_rest(double *C, int ldc, mukca_columns X, mukca_columns Y, int m, int width)
{
    for (int i = 0; i < X.n; i += 8) {
        const mukca_columns x = from(X, i, 8);
        const long last = (long)(m - 1) * x.ld + x.n - 8;
        const int inside = x.n == 8 ? m : last < 0 ? 0 : (int)(last / x.ld) + 1;
        double block[64] = {0}, row[8] = {0};
        panel(block, 8, Y, x, inside, 8, width);
        for (long r = inside; r < m; r++) {
            for (int c = 0; c < x.n; c++) row[c] = x.x[r * x.ld + c];
            panel(block, 8, (mukca_columns){Y.x + r * Y.ld, Y.n, Y.ld}, (mukca_columns){row, 8, 8},
                  1, 8, width);
        }
        for (int c = 0; c < x.n; c++)
            for (int j = 0; j < Y.n; j++) C[(long)(i + c) * ldc + j] += block[8 * j + c];
    }
}

/* C[X.n][Y.n] += X' Y, row stride of C: ldc; `upper`: only blocks with entries of the upper
 * triangle (symmetric product). */
MUKCA_INLINE void gram_any(double *C, int ldc, mukca_columns X, mukca_columns Y, int m, bool upper,
                           int width)
{
    const int k8 = Y.n & ~7, k16 = width == 8 ? k8 & ~15 : 0;
    for (int r = 0; r < m; r += STRIP) {
        const int rows = m - r < STRIP ? m - r : STRIP;
        for (int j = 0; j < k16; j += 16)
            for (int i = 0; i < X.n && (!upper || i < j + 16); i += 8)
                panel(C + (long)i * ldc + j, ldc, from(X, i, 8), from(Y, j, 16), rows, 16, width);
        for (int j = k16; j < k8; j += 8)
            for (int i = 0; i < X.n && (!upper || i <= j); i += 8)
                panel(C + (long)i * ldc + j, ldc, from(X, i, 8), from(Y, j, 8), rows, 8, width);
        if (k8 < Y.n) gram_rest(C + k8, ldc, X, from(Y, k8, 8), rows, width);
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

/* Register v of a row of b. */
#define AT(vector, row, v) \
    (*(vector *)(void *)(b + (long)(row)*ld + (int)(sizeof(vector) / sizeof *b) * (v)))

/* Solve L x = b for eight right-hand sides b[n][8], row stride `ld`: some rows at a time, with
 * sums in registers. */
#define FORWARD(name, vector, at_once, registers)                                  \
    MUKCA_INLINE void name(double *b, int ld, const double *L, int ldl, int n)     \
    {                                                                              \
        enum { MOST = (at_once), REGISTERS = (registers) };                        \
        for (int i = 0; i < n; i += MOST) {                                        \
            const int rows = n - i < MOST ? n - i : MOST;                          \
            const double *l[MOST];                                                 \
            vector x[MOST][REGISTERS];                                             \
            for (int r = 0; r < MOST; r++) { /* beyond the last row: that again */ \
                const int row = i + (r < rows ? r : rows - 1);                     \
                l[r] = L + (long)row * ldl;                                        \
                for (int v = 0; v < REGISTERS; v++) x[r][v] = AT(vector, row, v);  \
            }                                                                      \
            for (int j = 0; j < i; j++)                                            \
                for (int v = 0; v < REGISTERS; v++) {                              \
                    const vector y = AT(vector, j, v);                             \
                    for (int r = 0; r < MOST; r++) x[r][v] -= l[r][j] * y;         \
                }                                                                  \
            for (int r = 0; r < rows; r++)                                         \
                for (int v = 0; v < REGISTERS; v++) {                              \
                    for (int j = 0; j < r; j++) x[r][v] -= l[r][i + j] * x[j][v];  \
                    x[r][v] /= l[r][i + r];                                        \
                    AT(vector, i + r, v) = x[r][v];                                \
                }                                                                  \
        }                                                                          \
    }
FORWARD(forward_by_eight, eight, 8, 1)
FORWARD(forward_by_four, four, 4, 2)
FORWARD(forward_by_two, pair, 2, 4)

MUKCA_INLINE void mukca_dense_forward_part_any(double *b, int ld, const double *L, int ldl, int n,
                                               int width)
{
    if (width == 8)
        forward_by_eight(b, ld, L, ldl, n);
    else if (width == 4)
        forward_by_four(b, ld, L, ldl, n);
    else
        forward_by_two(b, ld, L, ldl, n);
}

MUKCA_INLINE void mukca_dense_eight_rows_any(double *A, int i, int n, int width)
{
    double b[8 * MUKCA_DENSE_WIDEST], block[64] = {0};
    double *row = A + (long)i * n;
    for (int r = 0; r < 8; r++)
        for (int j = 0; j < i; j++) b[8 * j + r] = row[(long)r * n + j];
    mukca_dense_forward_part_any(b, 8, A, n, i, width);
    panel(block, 8, (mukca_columns){b, 8, 8}, (mukca_columns){b, 8, 8}, i, 8, width);
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
