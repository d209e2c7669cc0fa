/* Noise of samples that are not independent, and the whitening of their rows.
 *
 * A block of samples has the covariance sigma^2 V for each coordinate, and may have a free mean.  V
 * has unit diagonal and belongs to one of two families.  AR(1): successive samples correlate by
 * rho^distance.  Shared: samples of one posture have a common error of the variance `shared`, and
 * own errors of the variance 1 - shared; means of successive postures correlate by rho^distance.
 * Coordinates may correlate: V is multiplied by L from the left and by L' from the right, with an L
 * for each sample; in the family `shared`, one for the mean of a posture and another one for the
 * deviations from it.
 */
#ifndef MUKCA_INFER_WHITENING_H
#define MUKCA_INFER_WHITENING_H

#include <stdbool.h>

#include "base/pool.h"

typedef struct {
    double rho, shared;
} mukca_noise_family;

typedef struct {
    int start, count; /* samples */
    bool free_mean;
} mukca_block;

/* Samples of a regression; each has `dim` rows, one for each coordinate. */
typedef struct {
    int n_samples, n_blocks, dim;
    mukca_block *block;
    /* [n_samples] next sample of its posture and block, -1: none; number of samples from it on, 0:
     * not the first of its posture */
    int *next, *readings;
} mukca_samples;

/* Lower triangular L[n_samples][dim][dim] of the samples, or of postures at their first samples;
 * NULL: 1. */
typedef struct {
    const double *mean, *deviation;
} mukca_noise_shape;

/* V^-1/2 of one family, without the free means. */
typedef struct {
    mukca_noise_family family;
    mukca_noise_shape shape;
    double *diagonal, *before; /* [n_samples] factors of a sample and its predecessor */
    double *common;            /* [n_samples] of the sum over a posture, at its first sample */
    double *level;             /* [n_samples] of a value that all readings of a posture have */
    double *one;    /* [n_samples][dim][dim] whitened columns of ones, of each coordinate */
    double *total;  /* [n_blocks][dim][dim] Cholesky factors of their products */
    double log_det; /* log density of the rows beyond -dof log(sigma) - squares / 2 */
    int dof;
} mukca_whitening;

/* Memory for at most so many samples and blocks comes from `pool`.  False: no memory. */
bool mukca_whitening_create(mukca_whitening *whitening, mukca_pool *pool, int samples, int blocks,
                            int dim);

/* Factor V for these samples; weight[n_samples] (NULL: none) multiplies the rows of
 * independent samples.  The arrays of `shape` are not copied. */
void mukca_whitening_set(mukca_whitening *whitening, const mukca_samples *samples,
                         mukca_noise_family family, mukca_noise_shape shape, const double *weight);

/* x[dim] := product of the inverse of a block's information about its free mean with x. */
void mukca_whitening_solve(double *x, const mukca_whitening *whitening, int block, int dim);

/* n columns of matrices with the row stride ld. */
typedef struct {
    int n, ld;
    const double *x; /* [n_samples][dim][ld] */
    double *white;   /* the same shape; may be x */
    double *mean;    /* [n_blocks][dim][ld] estimated means of the blocks, or NULL */
} mukca_whitened;

/* white := V^-1/2 x without its components along free means.  The squares of such rows are those of
 * the likelihood with the means integrated out. */
void mukca_whitening_apply(const mukca_whitened *columns, const mukca_whitening *whitening,
                           const mukca_samples *samples);

/* out[n_samples][dim][ld] := (V^-1/2)' x for n whitened columns of the same shape: their products
 * with columns that are not whitened. */
void mukca_whitening_transpose(double *out, const double *x, int n, int ld,
                               const mukca_whitening *whitening, const mukca_samples *samples);

#endif
