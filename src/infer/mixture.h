/* Evidence of a block of coefficients whose prior is a mixture of sizes. */
#ifndef MUKCA_INFER_MIXTURE_H
#define MUKCA_INFER_MIXTURE_H

#include <stdbool.h>

enum { MUKCA_MOST_TERMS = 64, MUKCA_MOST_SIZES = 8 };

/* Columns of neighbours whose Gram blocks are cut out of one product: a panel of the kernel. */
enum { MUKCA_NEIGHBOURS = 16 };

/* The coefficients are independent Gaussians of one of several standard deviations. */
typedef struct {
    int n_sizes;
    double size[MUKCA_MOST_SIZES], log_weight[MUKCA_MOST_SIZES];
    bool nonnegative; /* the first coefficient */
} mukca_mixture;

/* Scratch: factors for all prior sizes, and matrices of the callers. */
typedef struct {
    double L[MUKCA_MOST_TERMS * (MUKCA_MOST_TERMS + 1) / 2][MUKCA_MOST_SIZES],
        x[MUKCA_MOST_TERMS][MUKCA_MOST_SIZES];
    double A[MUKCA_MOST_TERMS * MUKCA_MOST_TERMS], B[MUKCA_MOST_TERMS * MUKCA_MOST_TERMS],
        C[MUKCA_MOST_TERMS * MUKCA_MOST_TERMS], D[MUKCA_MOST_TERMS * MUKCA_MOST_TERMS];
} mukca_mixture_scratch;

/* Projected normal equations of some columns, G[terms][terms] and g[terms]; the squared residual
 * without them, in units of the noise, and its degrees of freedom. */
typedef struct {
    const double *G, *g;
    int terms, dof;
    double residual;
} mukca_equations;

/* Log Bayes factor of the columns' coefficients, averaged over the sizes, with the scale of the
 * noise profiled out.  by_size[n_sizes] (may be NULL) receives the terms of the average.  Changes L
 * and x of the scratch. */
double mukca_mixture_evidence(double *by_size, const mukca_equations *columns,
                              const mukca_mixture *prior, mukca_mixture_scratch *scratch);

/* Log of twice the posterior probability that a coefficient with this mean and variance, in units
 * of the noise, is positive. */
double mukca_mixture_positive(double mean, double variance, double residual, int dof);

#endif
