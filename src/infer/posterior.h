/* Posterior of the coefficients of a linear Gaussian model.
 *
 * The priors are independent Gaussians of standard deviations D.  With the precision P of the data,
 * 1 + D P D = L L'.  (C. M. Bishop, Pattern Recognition and Machine Learning, 2006, section 3.5.)
 */
#ifndef MUKCA_INFER_POSTERIOR_H
#define MUKCA_INFER_POSTERIOR_H

#include <stdbool.h>

#include "base/pool.h"

typedef struct {
    int n, value;     /* coefficients; column of the value in a row */
    double *prior;    /* [n] D, set by the caller */
    double *factor;   /* [n][n] L */
    double *work;     /* [n] L^-1 D times the products of coefficients and value */
    double quadratic; /* squares of residuals and of deviations from the prior over variances */
    double log_det;   /* of L */
} mukca_posterior;

/* Memory for at most n coefficients. */
void mukca_posterior_take(mukca_posterior *posterior, mukca_pool *pool, int n);

/* Begin with the products gram[width][width] of rows of that precision (the lower triangle is
 * used). The first n columns are of the coefficients, the last one is the value.  Then add single
 * rows. */
void mukca_posterior_start(mukca_posterior *posterior, const double *gram, int n, int width,
                           double precision);
void mukca_posterior_add(mukca_posterior *posterior, const double *row, double precision);

/* Factorise; mean[n] (may be NULL) receives the posterior mean.  False: not positive definite. */
bool mukca_posterior_solve(mukca_posterior *posterior, double *mean);

/* Variance of row[n] times the coefficients; overwrites the row. */
double mukca_posterior_variance(double *row, const mukca_posterior *posterior);

/* ---- positions in groups, the means of which have no prior ---- */

/* Known distance between the means of two groups; the pairs of an artefact have one error. */
typedef struct {
    int a, b, artefact;
    double sigma; /* standard deviation of that error, m */
} mukca_group_pair;

/* Products of rows are summed: adding and removing a position is cheap. */
typedef struct {
    mukca_posterior posterior;
    int size, n_groups, n_pairs; /* size: n + 1 */
    double noise;                /* standard deviation of a coordinate, m */
    mukca_group_pair *pair;      /* [n_pairs] */
    double *gram;                /* [size][size] of coefficients and value, over all groups */
    double *sum;                 /* [n_groups][3][size] of rows */
    int *count;                  /* [n_groups] */
    double *row, *common;        /* [size] scratch */
} mukca_grouped;

/* Without positions, with unit priors.  False: no memory. */
bool mukca_grouped_create(mukca_grouped *grouped, mukca_pool *pool, int n, int groups, int pairs);

/* Add (sign 1) or remove (-1) the rows x[3][size] of a position: derivatives by the coefficients,
 * and minus the position, m. */
void mukca_grouped_add(mukca_grouped *grouped, const double *x, int group, int sign);

/* Factor the posterior of the coefficients, with the means and the errors integrated out. */
void mukca_grouped_solve(mukca_grouped *grouped);

#endif
