/* The MUKCa cost (arXiv 2503.12584, equation 5), summed over placements, with its
 * gradient:
 *     J = sum over placements of  (sum_s N_s tr Sigma_s) / (sum_s N_s)
 *                               + sum over pairs of sockets of (|mu_a - mu_b| - d)^2
 *                               + lambda |theta - theta_nominal|^2.
 * Measured poses count as one more placement, whose first term is the mean squared residual.
 */
#ifndef MUKCA_FIT_COST_H
#define MUKCA_FIT_COST_H

#include "fit/observe.h"

#define MUKCA_LAMBDA 1e-4

typedef struct mukca_cost mukca_cost;

/* Zeroed means the defaults. */
typedef struct {
    double lambda;           /* 0: MUKCA_LAMBDA; negative: no regularisation */
    mukca_gradient gradient; /* method of an element's derivative */
    const double *theta;     /* [6 * n_elements] values of frozen parameters; NULL: nominal */
    mukca_cost *part;        /* for mukca_cost_setup (solver.h); NULL: none */
} mukca_cost_options;

typedef struct {
    double total, inconsistency, distortion, regularisation; /* m^2 */
} mukca_cost_value;

struct mukca_cost {
    const mukca_parameters *parameters;
    mukca_observations observations;
    double lambda;   /* of one placement */
    int n;           /* free parameters */
    int evaluations; /* of value, with or without gradient */
    double *theta;   /* [6 * n_elements] scratch; frozen entries hold their value */
    double *nominal; /* [n] */
    /* of mukca_cost_setup; NULL: none */
    void (*more)(mukca_cost_value *parts, double *gradient, mukca_cost *cost, const double *x);
    mukca_cost *part; /* the owner of r, J and weight: this cost or that of the options */
    double *r, *J;    /* [n_residuals], [n_residuals][n] scratch */
    double *weight;   /* [n_residuals] square roots */
    double *matrix[3], *vector[4]; /* [n][n], [n] scratch of solvers */
    int n_held;                    /* directions held near the start (mukca_cost_hold) */
    double *held, *held_at;        /* [n_held][n] unit vectors, [n_held] coordinates along them */
};

/* Weight of the regularisation: lambda of every placement. */
static inline double mukca_cost_lambda(const mukca_cost *cost)
{
    return cost->lambda * cost->observations.n_groups;
}

/* The cost of sockets, without Hessian; memory from the pool, false: out of memory.
 * Chain and parameters must outlive the cost; the cost must not be moved. */
bool mukca_cost_init(mukca_cost *cost, mukca_pool *pool, const mukca_chain *chain,
                     const mukca_parameters *parameters, const mukca_dataset *data,
                     const mukca_cost_options *options);

/* J at x[n], m^2; its parts and its gradient[n] may be NULL.  Allocates nothing. */
double mukca_cost_evaluate(mukca_cost_value *parts, double *gradient, mukca_cost *cost,
                           const double *x);

#endif
