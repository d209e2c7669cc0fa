/* A whole fit: free parameters, cost, solver, verdict, identifiability. */
#ifndef MUKCA_FIT_FIT_H
#define MUKCA_FIT_FIT_H

#include "fit/identify.h"
#include "fit/solver.h"

/* Zeroed means the defaults. */
typedef struct {
    mukca_selection selection;
    bool free_base, free_tool; /* fit the frame and the offset of measured poses, too */
    mukca_cost_options cost;
    const mukca_solver *solver; /* NULL: Gauss-Newton */
    mukca_solver_options limits;
    const double *start;  /* [6 * chain.n_elements] where the solver begins; NULL: nominal values */
    bool parameters_only; /* theta alone: neither convergence nor identifiability */
} mukca_fit_options;

/* Of more samples than this, Hessian, rank and standard errors are computed from so many (part.h):
 * a standard error from N samples is known to some sqrt(2 / N), here 1 %, and the Hessian leads the
 * solver to the minimum of all samples, however rough it is. */
enum { MUKCA_FIT_PART = 20000 };

typedef struct {
    mukca_chain chain; /* that was fitted: with base_frame, tool_frame where asked for */
    mukca_parameters parameters;
    double theta[MUKCA_MAX_FREE]; /* [6 * chain.n_elements], calibrated */
    mukca_cost_value nominal, calibrated;
    mukca_solver_outcome outcome;
    bool converged; /* our own verdict, at the point returned */
    double to_gain; /* decrease of the cost that one more step promises, over the cost */
    int n_measured; /* scalar measurements that parameters can use */
    int n_part;     /* samples that the standard errors are computed from; 0: all */
    mukca_identification identification;
    double *null_space; /* [n - rank][n] as mukca_identify gives it; NULL without a fit */
    double *memory;     /* owned */
} mukca_fit;

/* Fit `data` from nominal.  Allocates; free with mukca_fit_free.  Errors: MUKCA_USAGE, MUKCA_INPUT,
 * MUKCA_MEMORY, MUKCA_INTERRUPTED.  Not having converged is a result. */
mukca_status mukca_fit_run(mukca_fit *fit, const mukca_chain *chain, const mukca_dataset *data,
                           const mukca_fit_options *options, mukca_error *error);

/* Harmless on a zeroed one. */
void mukca_fit_free(mukca_fit *fit);

#endif
