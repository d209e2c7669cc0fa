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

/* Factorise; mean[n] (may be NULL) receives the posterior mean, for prior means centre[n] (NULL:
 * 0).  False: not positive definite. */
bool mukca_posterior_solve(mukca_posterior *posterior, const double *centre, double *mean);

/* Variance of row[n] times the coefficients; overwrites the row. */
double mukca_posterior_variance(double *row, const mukca_posterior *posterior);

/* ---- observations in groups, each with unknowns of its own without a prior: a mean, a frame ----
 */

/* Columns of a group's own unknowns, at most; the first three are its mean. */
enum { MUKCA_OWN = 9 };

/* An observation x[3][width]: rows of its group's own columns, those of the n coefficients, and its
 * value, m. */
typedef struct {
    int group;
    double weight, *x;
} mukca_observation;

/* Known distance between the means of two groups, m; the pairs of an artefact have one error. */
typedef struct {
    int a, b, artefact;
    bool used;
    double distance, sigma; /* sigma: standard deviation of that error, 0: none */
} mukca_group_pair;

/* Products of rows are summed: adding and removing an observation is cheap. */
typedef struct {
    mukca_posterior posterior;
    int width, n_groups, n_pairs;
    double noise;  /* standard deviation of a coordinate, m */
    double misfit; /* squares over the variance of the observations whose residuals are proportional
                      to the distances: the likelihood of this scale; 0: none are */
    mukca_group_pair *pair; /* [n_pairs] */
    double *gram;           /* [n + 1][n + 1] of coefficients and value, over all groups */
    double *own;            /* [n_groups][OWN][width] of own columns with all */
    double *weight;         /* [n_groups] of their observations */
    double *reduced;        /* as `own`, each column without the components along those before it */
    double *row, *common;   /* [n + 1] scratch */
    double *block;          /* [BLOCK][n + 1] scratch */
    double *mean;           /* [n] posterior mean */
    double *solution;       /* [n_groups][OWN] own unknowns at that mean */
    int n_own;              /* of all groups, those that the observations determine */
} mukca_grouped;

/* Without observations, with unit priors.  False: no memory. */
bool mukca_grouped_create(mukca_grouped *grouped, mukca_pool *pool, int n, int groups, int pairs);

/* Remove all observations. */
void mukca_grouped_clear(mukca_grouped *grouped);

/* Add an observation of that weight; a negative one removes it, exactly if its own columns are 0 or
 * 1. */
void mukca_grouped_add(mukca_grouped *grouped, const double *x, int group, double weight);

/* Add n observations: the same, by products of many rows. */
void mukca_grouped_add_all(mukca_grouped *grouped, const mukca_observation *list, int n);

/* Solve for the coefficients (centre: their prior means, NULL: 0) and all own unknowns. */
void mukca_grouped_solve(mukca_grouped *grouped, const double *centre);

/* row[n + 1] of a pair of groups that only have means: derivatives of its distance, and the known
 * one minus that at coefficients 0; variance: of the latter, by the observations.  False: one has
 * no observation. */
bool mukca_grouped_pair(double *row, double *variance, const mukca_grouped *grouped, int pair);

/* Residual of an observation at the solution; returns its length. */
double mukca_grouped_residual(double residual[3], const mukca_grouped *grouped, const double *x,
                              int group);

#endif
