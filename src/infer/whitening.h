/* Noise of samples that are not independent, and the whitening of their rows.
 *
 * A block of samples has the covariance sigma^2 V for each coordinate, and may have a free mean.  V
 * has unit diagonal and belongs to one of two families.  AR(1): successive samples correlate by
 * rho^distance.  Shared: samples of one posture have a common error of the variance `shared`, and
 * own errors of the variance 1 - shared; means of successive postures correlate by rho^distance.
 * Own errors of the coordinates may correlate: readings deviate from their posture's mean with the
 * covariance L L' instead of 1 (that of the mean, which shared errors dominate, stays). */
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

/* V^-1/2 of one family, without the free means. */
typedef struct {
    mukca_noise_family family;
    double *own, *before; /* [n_samples] factors of a sample and its predecessor */
    double *common;       /* [n_samples] of the sum over a posture, at its first sample */
    double *one;          /* [n_samples] whitened column of ones */
    double *total;        /* [n_blocks] its squared length */
    const double *shape;  /* [n_samples][dim][dim] L at the first sample of a posture; NULL: 1 */
    double log_det;       /* log density of the rows beyond -dof log(sigma) - squares / 2 */
    int dof;
} mukca_whitening;

/* Memory for at most so many samples and blocks comes from `pool`.  False: no memory. */
bool mukca_whitening_create(mukca_whitening *whitening, mukca_pool *pool, int samples, int blocks);

/* Factor V for these samples; weight[n_samples] (NULL: none) multiplies the rows of
 * independent samples; shape (may be NULL) is kept, and used by families that share errors. */
void mukca_whitening_set(mukca_whitening *whitening, const mukca_samples *samples,
                         mukca_noise_family family, const double *weight, const double *shape);

/* n columns of matrices with the row stride ld. */
typedef struct {
    int n, ld;
    const double *x; /* [n_samples][dim][ld] */
    double *white;   /* the same shape, not x */
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
