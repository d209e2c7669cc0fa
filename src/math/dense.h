/* Small dense linear algebra, row-major, no allocation: products, Cholesky, QR, SVD.
 *
 * Shapes are given as (rows, columns); A[m][n] lies at A[i * n + j] unless a row stride ld is
 * given.
 */
#ifndef MUKCA_MATH_DENSE_H
#define MUKCA_MATH_DENSE_H

/* C[n][n] += X' X for X[m][n] (lower triangle and upper alike).  The workhorse; vectorised. */
void mukca_dense_syrk(double *C, int n, const double *X, int m, int ldx);

/* n neighbouring columns of a matrix with row stride ld. */
typedef struct {
    const double *x;
    int n, ld;
} mukca_columns;

/* C[X.n][Y.n] += X' Y over m rows; `symmetric`: X.n equals Y.n and the product is known to be
 * symmetric, so that half of it is formed. */
void mukca_dense_xty(double *C, mukca_columns X, mukca_columns Y, int m);
void mukca_dense_symmetric(double *C, mukca_columns X, mukca_columns Y, int m);

/* Cholesky A = L L' in place (lower; the upper triangle is left alone).  Returns 0, or 1 + the
 * index of the first pivot that is not positive (also for NaN). */
int mukca_dense_cholesky(double *A, int n);

/* Solve L x = b, and L' x = b, in place for k right-hand sides b[n][k]. */
void mukca_dense_forward(double *b, int k, const double *L, int n);
void mukca_dense_backward(double *b, int k, const double *L, int n);

/* L x = b for b[n][ld], the first k columns of it: a multiple of 8. */
void mukca_dense_forward8(double *b, int k, int ld, const double *L, int n);

/* Q'A Q is tridiagonal for A[n][n] (upper triangle; destroyed): T[0..n) gets its diagonal, T[n..2n)
 * the off-diagonal entries (0 behind the last), T[4n] is scratch.  B[n][k] becomes Q'B. */
void mukca_dense_tridiagonalise(double *A, int n, double *T, double *B, int k);

/* One-sided Jacobi SVD of A[m][n], m >= n, in place: A becomes U (columns orthonormal where the
 * singular value is not 0), s[n] descending, V[n][n] (A = U diag(s) V').  V may be NULL.
 * Returns 0, or 1 when it did not converge in 60 sweeps (also for NaN or infinity). */
int mukca_dense_svd(double *A, double *s, double *V, int m, int n);

/* Gauss-Jordan with full pivoting on N[k][n] (row stride ld): each row becomes 1 in a column of its
 * own, where the others are 0, so that few entries remain. */
void mukca_dense_reduce(double *N, int k, int n, int ld);

/* Sequential (block) QR for least squares whose rows come one at a time: R[n][n + k] is the upper
 * triangular factor of all rows so far, then Q'b, zeroed at the start.  Absorbs the rows
 * A[m][n + k] (destroyed).  rss[k] (may be NULL) accumulates the squares that left the triangle.
 * Memory and result do not depend on how the rows are blocked (to rounding). */
void mukca_dense_qr_absorb(double *R, double *rss, double *A, int m, int n, int k);

#endif
