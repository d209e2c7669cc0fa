/* One interface for all minimisers of the cost. */
#ifndef MUKCA_FIT_SOLVER_H
#define MUKCA_FIT_SOLVER_H

#include "fit/cost.h"
#include "fit/nlopt_adapter.h"

/* Zeroed means the defaults. */
typedef struct {
    int max_evaluations;         /* 0: 2000 */
    bool (*stop)(void *context); /* called before each evaluation, true: stop; may be NULL */
    void *context;               /* of `stop` */
} mukca_solver_options;

/* Time limit of a solver, s: a converging fit needs less than a second. */
#define MUKCA_SOLVER_SECONDS 60.0

typedef struct {
    int evaluations, iterations; /* iterations: points better than all before */
    mukca_stop stop;
} mukca_solver_outcome;

typedef struct mukca_solver {
    mukca_nlopt_method method; /* of NLopt's */
    /* Minimise from x[n] (in/out: the best point seen).  Errors: MUKCA_MEMORY (NLopt's own). */
    mukca_status (*run)(double *x, mukca_solver_outcome *outcome, mukca_cost *cost,
                        const struct mukca_solver *solver, const mukca_solver_options *options,
                        mukca_error *error);
} mukca_solver;

extern const mukca_solver mukca_solver_gauss_newton;

/* All solvers, the default first, and their names; ended by NULL.  Not part of the core library. */
extern const mukca_solver *const mukca_solver_table[];
extern const char *const mukca_solver_name[];

/* For solvers: replace H[n][n] by L with L L' = H + ridge; the ridge keeps flat directions
 * solvable. */
void mukca_solver_factorise(double *H, int n);

/* For solvers: g' H^-1 g / 4, the predicted decrease of the cost by a Gauss-Newton step; L as
 * above, work[n]. */
double mukca_solver_decrement(const double *L, const double *gradient, double *work, int n);

/* Predicted decrease below which a solver stops. */
double mukca_solver_goal(double cost);

/* ---- the cost with measured poses, its Gauss-Newton Hessian ---- */

/* As mukca_cost_init, with measured poses and memory for Hessian and solvers.  With
 * options->part, the cost of a representative part of the samples, Hessian and precision
 * are computed from that part, without a Jacobian of all samples. */
bool mukca_cost_setup(mukca_cost *cost, mukca_pool *pool, const mukca_chain *chain,
                      const mukca_parameters *parameters, const mukca_dataset *data,
                      const mukca_cost_options *options);

/* From here on regularise towards x[n] each direction v of the unregularised parameters that the
 * data determine less than lambda would: nearly identical samples would otherwise move the ball by
 * kilometres.  The term is lambda (v'(x - x0))^2, as for the regularised parameters. */
void mukca_cost_hold(mukca_cost *cost, const double *x);

/* Half the Gauss-Newton Hessian, H[n][n] = J'WJ + lambda I for the regularised or held directions;
 * without lambda if `data_only`.  Leaves the weighted Jacobian in cost->part->J. */
void mukca_cost_normal(double *H, mukca_cost *cost, const double *x, bool data_only);

#endif
