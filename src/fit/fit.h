/* A whole fit: free parameters, cost, solver, verdict, identifiability. */
#ifndef MUKCA_FIT_FIT_H
#define MUKCA_FIT_FIT_H

#include "fit/identify.h"
#include "fit/selection.h"
#include "fit/solver.h"

/* Zeroed means the defaults. */
typedef struct {
    mukca_selection selection;
    bool free_base, free_tool; /* also fit the frame and the offset of measured poses */
    mukca_cost_options cost;
    const mukca_solver *solver; /* NULL: Gauss-Newton */
    mukca_solver_options limits;
    const double *start;  /* [6 * chain.n_elements] initial values; NULL: nominal */
    bool parameters_only; /* only theta: no test of convergence, no identifiability */
    bool by_evidence;     /* sockets only: the posterior mean (arm_posterior.h), no solver */
} mukca_fit_options;

/* Beyond this number of samples, Hessian, rank and standard errors are computed from so many
 * (part.h): a standard error from N samples is known to some sqrt(2 / N), here 1 %, and an
 * approximate Hessian changes only the solver's steps, not the minimum. */
enum { MUKCA_FIT_PART = 20000 };

typedef struct {
    mukca_chain chain; /* as fitted: with base_frame and tool_frame if requested */
    mukca_parameters parameters;
    double theta[MUKCA_MAX_FREE]; /* [6 * chain.n_elements], calibrated */
    mukca_cost_value nominal, calibrated;
    mukca_solver_outcome outcome;
    bool converged; /* by our own criterion, at the point returned */
    double to_gain; /* predicted relative decrease of the cost by one more step */
    int n_measured; /* scalar measurements less one mean per socket */
    int n_part;     /* samples used for the standard errors; 0: all */
    mukca_identification identification;
    double *null_space; /* [n - rank][n] from mukca_identify; NULL without a fit */
    double *memory;     /* owned */
} mukca_fit;

/* Fit to `data`, from nominal.  Allocates; free with mukca_fit_free.  Errors: MUKCA_USAGE,
 * MUKCA_INPUT, MUKCA_MEMORY, MUKCA_INTERRUPTED.  Failure to converge is a result, not an error. */
mukca_status mukca_fit_run(mukca_fit *fit, const mukca_chain *chain, const mukca_dataset *data,
                           const mukca_fit_options *options, mukca_error *error);

/* A zeroed fit is allowed. */
void mukca_fit_free(mukca_fit *fit);

#endif
