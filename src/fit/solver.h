/* One interface for all minimisers of the cost. */
#ifndef MUKCA_FIT_SOLVER_H
#define MUKCA_FIT_SOLVER_H

#include "fit/cost_normal.h"
#include "fit/stop.h"

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

/* Minimise from x[n] (in/out: the best point seen).  Errors: MUKCA_MEMORY (NLopt's own). */
typedef mukca_status mukca_solver_fn(double *x, mukca_solver_outcome *outcome, mukca_cost *cost,
                                     const mukca_solver_options *options, mukca_error *error);

typedef struct {
    const char *name;
    mukca_solver_fn *run;
} mukca_solver;

extern const mukca_solver mukca_solver_gauss_newton;

/* "slsqp" (the default), "lbfgs", "gauss-newton"; ended by NULL.  Not part of the core library. */
extern const mukca_solver *const mukca_solver_table[];

/* For solvers: replace H[n][n] by L with L L' = H + ridge; the ridge keeps flat directions
 * solvable. */
void mukca_solver_factorise(double *H, int n);

/* For solvers: g' H^-1 g / 4, the predicted decrease of the cost by a Gauss-Newton step; L as
 * above, work[n]. */
double mukca_solver_decrement(const double *L, const double *gradient, double *work, int n);

/* Predicted decrease below which a solver stops. */
double mukca_solver_goal(double cost);

#endif
