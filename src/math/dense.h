/* Small dense linear algebra, row-major, no allocation: products, Cholesky, QR, SVD.
 *
 * Shapes are given as (rows, columns); entry (i, j) of A[m][n] is A[i * n + j], or A[i * ld + j]
 * with a row stride ld.
 */
#ifndef MUKCA_MATH_DENSE_H
#define MUKCA_MATH_DENSE_H

#include <stdbool.h>

#include "mukca/rotation.h"

/* C[n][n] += X' X for X[m][n], both triangles.  Vectorised, as most time is spent here. */
void mukca_dense_syrk(double *C, int n, const double *X, int m, int ldx);

/* n neighbouring columns of a matrix with row stride ld. */
typedef struct {
    const double *x;
    int n, ld;
} mukca_columns;

/* C[X.n][Y.n] += X' Y over m rows; `part`: the row stride of C is ldc; `symmetric`: X.n equals Y.n
 * and the product is symmetric; only half of it is computed. */
void mukca_dense_xty(double *C, mukca_columns X, mukca_columns Y, int m);
void mukca_dense_xty_part(double *C, int ldc, mukca_columns X, mukca_columns Y, int m);
void mukca_dense_symmetric(double *C, mukca_columns X, mukca_columns Y, int m);

/* Cholesky A = L L' in place (lower; the upper triangle is unchanged).  False: a pivot is not
 * positive (also for NaN). */
bool mukca_dense_cholesky(double *A, int n);

/* Columns [0, i) of the factor's rows i to i + 7, by forward substitution with the rows as
 * right-hand sides, and their subtraction from the next eight columns; 13 kB of stack. */
enum { MUKCA_DENSE_WIDEST = 200 }; /* largest i */
void mukca_dense_eight_rows(double *A, int i, int n);

/* Solve A x = b in place for k right-hand sides b[n][k]; A as above.  Returns likewise. */
bool mukca_dense_solve(double *b, int k, double *A, int n);

/* Solve L x = b, and L' x = b, in place for k right-hand sides b[n][k]. */
void mukca_dense_forward(double *b, int k, const double *L, int n);
void mukca_dense_backward(double *b, int k, const double *L, int n);

/* x' A x for A[n][n] with row stride lda. */
double mukca_dense_quadratic(const double *x, const double *A, int lda, int n);

/* |L^-1 a|^2: the variance of a' x, if L L' is the precision of x; a[n] is overwritten. */
double mukca_dense_variance(double *a, const double *L, int n);

/* Solve L x = b for the first k columns of b[n][ld], k a multiple of 8; `part`: for eight, L with
 * row stride ldl. */
void mukca_dense_forward8(double *b, int k, int ld, const double *L, int n);
void mukca_dense_forward_part(double *b, int ld, const double *L, int ldl, int n);

/* One-sided Jacobi SVD of A[n][n] in place: A becomes U (columns with singular value > 0 are
 * orthonormal), s[n] descending, V[n][n] (A = U diag(s) V').  Of more rows: mukca_dense_qr_absorb
 * first.  False: no convergence in 60 sweeps (also for NaN or infinity). */
bool mukca_dense_svd(double *A, double *s, double *V, int n);

/* Remove the columns first .. end - 1 of X[rows][width] from those after them (Gram-Schmidt). */
void mukca_dense_project(double *X, int rows, int width, int first, int end);

/* Sequential QR for least squares, by blocks of rows: R[n][n + k] is the upper triangular factor of
 * all rows so far, followed by Q'b; zero initially.  Absorbs the rows A[m][n + k], of which the
 * residuals of b remain. */
void mukca_dense_qr_absorb(double *R, double *A, int m, int n, int k);

/* x[n] of least squares from R[n][n + 1]; 0 where nothing determines it. */
void mukca_dense_qr_solve(double *x, const double *R, int n);

/* R := exp([w]x) R, or R exp([w]x) with `own_axes`. */
void mukca_rotation_turn(double R[9], const double w[3], bool own_axes);

/* y = R x + p */
static inline void mukca_frame_point(double y[3], const mukca_frame *T, const double x[3])
{
    mukca_mat3_vec(y, T->R, x);
    for (int i = 0; i < 3; i++) y[i] += T->p[i];
}

/* The pose that brings n points `from` nearest to the points `to`; `stride` numbers from one point
 * to the next. */
void mukca_frame_nearest(mukca_frame *pose, const double *to, const double *from, int stride,
                         int n);

/* A point `to`, with the orientation `turned` unless its first number is NaN, that base * from *
 * tool is to meet; weight: 1 / variance. */
typedef struct {
    mukca_frame from;
    double to[3], turned[9], weight;
    double at[3]; /* of the caller */
} mukca_meeting_point;

typedef struct {
    const mukca_meeting_point *points;
    int n;
    bool base, tool;   /* which are free */
    double pull;       /* of the tool's position towards 0: root of its weight */
    double per_radian; /* root of the weight of an orientation, m/rad; 0: none is used */
    double damping;    /* root of the weight that holds each number where it is */
} mukca_meeting;

/* Numbers of base and tool (translation, rotation), and of the factor of their equations. */
enum { MUKCA_MEETING = 12, MUKCA_MEETING_FACTOR = MUKCA_MEETING * (MUKCA_MEETING + 1) };

/* One Gauss-Newton step of base and tool; directions that no point determines stay.  R gets the
 * triangular factor of the equations.  Returns the largest element of the step, 0: not finite. */
double mukca_frame_refine(double R[MUKCA_MEETING_FACTOR], mukca_frame *base, mukca_frame *tool,
                          const mukca_meeting *meeting);

/* Standard errors sigma[n] of the first n numbers for residuals of 1, from the factor R, whose last
 * column it overwrites. */
void mukca_meeting_errors(double *sigma, double *R, int n);

#endif
