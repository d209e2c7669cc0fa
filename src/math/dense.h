/* Small dense linear algebra, row-major, no allocation: Cholesky, QR, SVD, symmetric eigenvalues.
 *
 * Shapes are given as (rows, columns); A[m][n] lies at A[i * lda + j] with lda >= n where an lda is
 * taken, else lda = n.  Nothing here allocates or fails silently: factorisations return a status
 * number documented at each function.
 */
#ifndef MUKCA_MATH_DENSE_H
#define MUKCA_MATH_DENSE_H

/* C[n][n] += X' X for X[m][n] (lower triangle and upper alike).  The workhorse; vectorised. */
void mukca_dense_syrk(double *C, int n, const double *X, int m, int ldx);

/* C[n][k] += X' Y for X[m][n], Y[m][k]. */
void mukca_dense_xty(double *C, int ldc, const double *X, int n, int ldx, const double *Y, int k,
                     int ldy, int m);

/* Cholesky A = L L' in place (lower; the upper triangle is left alone).  Returns 0, or 1 + the
 * index of the first pivot that is not positive (also for NaN). */
int mukca_dense_cholesky(double *A, int n);

/* Solve L x = b, and L' x = b, in place for k right-hand sides b[n][k]. */
void mukca_dense_forward(double *b, int k, const double *L, int n);
void mukca_dense_backward(double *b, int k, const double *L, int n);

/* Householder QR with column pivoting of A[m][n] in place: R in the upper triangle, the vectors
 * below, tau[min(m, n)], pivot[n] (column pivot[j] of A became column j).  Returns the numerical
 * rank: pivots above max(m, n) * eps * |R00|, or above `tolerance` * |R00| where that is > 0. */
int mukca_dense_qr(double *A, double *tau, int *pivot, int m, int n, double tolerance);

/* b[m] := Q' b, with the factorisation above. */
void mukca_dense_qr_apply(double *b, const double *A, const double *tau, int m, int n);

/* One-sided Jacobi SVD of A[m][n], m >= n, in place: A becomes U (columns orthonormal where the
 * singular value is not 0), s[n] descending, V[n][n] (A = U diag(s) V').  V may be NULL.
 * Returns 0, or 1 when it did not converge in 60 sweeps (also for NaN or infinity). */
int mukca_dense_svd(double *A, double *s, double *V, int m, int n);

/* Cyclic Jacobi eigenvalues of the symmetric A[n][n]: w[n] descending, V[n][n] columns the
 * eigenvectors (may be NULL); A is destroyed.  Returns as mukca_dense_svd. */
int mukca_dense_eigen(double *w, double *V, double *A, int n);

/* Minimum-norm least squares of A[m][n] x = b[m], singular values below tolerance * s[0] dropped.
 * A and b are destroyed; x[n]; work of n * n + n doubles.  m < n is handled.  Returns the rank, -1
 * when the SVD did not converge. */
int mukca_dense_lstsq(double *x, double *A, double *b, int m, int n, double tolerance,
                      double *work);

/* Sequential (block) QR for least squares whose rows come one at a time: R[n][n + k] is the upper
 * triangular factor of all rows so far beside Q'b, zeroed at the start.  Absorbs the rows
 * A[m][n + k] (destroyed).  rss[k] (may be NULL) accumulates the squares that left the triangle.
 * Memory and result do not depend on how the rows are blocked (to rounding). */
void mukca_dense_qr_absorb(double *R, double *rss, double *A, int m, int n, int k);

#endif
