/* The MUKCa cost (arXiv 2503.12584, equation 5), summed over placements, with gradient and
 * Gauss-Newton Hessian:
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
    bool nominal_means;      /* of sockets (older closed-chain method), not their own */
    bool no_distortion;      /* no distances between sockets */
    mukca_gradient gradient; /* method of an element's derivative */
    const double *theta;     /* [6 * n_elements] values of frozen parameters; NULL: nominal */
    mukca_cost *part; /* cost of a representative part of the samples (part.h), used for Hessian and
                         precision, without a Jacobian of all samples; NULL: none */
} mukca_cost_options;

typedef struct {
    double total, inconsistency, distortion, regularisation; /* m^2 */
} mukca_cost_value;

struct mukca_cost {
    const mukca_parameters *parameters;
    mukca_cost *part; /* the owner of r, J and weight below: this cost or that of the options */
    mukca_observations observations;
    mukca_gradient gradient;
    double lambda;      /* times the number of placements */
    double pair_weight; /* 1, or 0 without distortion */
    int n;              /* free parameters */
    int evaluations;    /* of value, with or without gradient */
    int n_held;         /* directions held near the start (mukca_cost_hold) */
    double *held;       /* [n_held][n] unit vectors */
    double *held_at;    /* [n_held] coordinates along them */
    double *theta;      /* [6 * n_elements] scratch; frozen entries hold their value */
    double *nominal;    /* [n] */
    double *r;          /* [n_residuals] scratch */
    double *J;          /* [n_residuals][n] scratch */
    double *weight;     /* [n_residuals] square roots */
    double *scratch;    /* [3][n][n] and [6][n] for solvers */
};

/* Allocate from the pool; false: out of memory.  `options` may be NULL.  Chain and parameters must
 * outlive the cost; the cost must not be moved. */
bool mukca_cost_setup(mukca_cost *cost, mukca_pool *pool, const mukca_chain *chain,
                      const mukca_parameters *parameters, const mukca_dataset *data,
                      const mukca_cost_options *options);

/* From here on regularise towards x[n] each direction v of the unregularised parameters that the
 * data determine less than lambda would: nearly identical samples would otherwise move the ball by
 * kilometres.  The term is lambda (v'(x - x0))^2, as for the regularised parameters. */
void mukca_cost_hold(mukca_cost *cost, const double *x);

/* J at x[n], m^2; its parts and its gradient[n] may be NULL.  Allocates nothing. */
double mukca_cost_evaluate(mukca_cost_value *parts, double *gradient, mukca_cost *cost,
                           const double *x);

/* Half the Gauss-Newton Hessian, H[n][n] = J'WJ + lambda I for the regularised or held directions;
 * without lambda if `data_only`.  Leaves the weighted Jacobian in cost->part->J. */
void mukca_cost_normal(double *H, mukca_cost *cost, const double *x, bool data_only);

#endif
