/* A whole fit: free parameters, cost, solver, verdict, identifiability. */
#ifndef MUKCA_FIT_FIT_H
#define MUKCA_FIT_FIT_H

#include "fit/solver.h"

/* ---- the user's lists of free and frozen parameters ---- */

/* The user's selection; zeroed: the default set.  A list is comma-separated; an item is
 *     joint              all six parameters of that URDF joint (fixed joints may be named too)
 *     parameter          x y z roll pitch or yaw, of every joint of the default set
 *     joint.parameter    one number
 * A joint with the name of a parameter takes precedence.  `free` replaces the default set; with a
 * leading + it adds to the set.  `freeze` is applied last. */
typedef struct {
    const char *free;    /* NULL: the default set */
    const char *freeze;  /* NULL: nothing */
    bool regularise_tip; /* also regularise the last fixed joint */
} mukca_selection;

/* The default set (parameters.h) as changed by the selection; added frames are always in the set
 * unless frozen.  Errors: MUKCA_USAGE (unknown name, nothing free). */
mukca_status mukca_parameters_select(mukca_parameters *parameters, const mukca_chain *chain,
                                     const mukca_selection *selection, mukca_error *error);

/* ---- identifiability: rank, null space, standard errors (identify.c) ---- */

typedef struct {
    int rank;
    double noise;         /* standard deviation of a sample's coordinate, m; from the residuals */
    double observability; /* (s_1 ... s_rank)^(1/rank) of the weighted Jacobian (index O1 of Borm
                             and Menq over the observable directions): m per m or rad */
    double sigma[MUKCA_MAX_FREE]; /* standard error of each free parameter; infinite if
                                     unidentifiable */
    unsigned char identifiable[MUKCA_MAX_FREE];
} mukca_identification;

/* Analyse at x[n].  Scratch comes from `pool`.  Errors: MUKCA_INPUT (the Jacobian is not finite),
 * MUKCA_MEMORY. */
mukca_status mukca_identify(mukca_identification *identification, mukca_cost *cost, const double *x,
                            mukca_pool *pool, mukca_error *error);

/* ---- the fit (fit.c) ---- */

/* Zeroed means the defaults. */
typedef struct {
    mukca_selection selection;
    bool free_base, free_tool; /* also fit the frame and the offset of measured poses */
    mukca_cost_options cost;
    const mukca_solver *solver; /* NULL: Gauss-Newton */
    mukca_solver_options limits;
    const double *start;  /* [6 * chain.n_elements] initial values; NULL: nominal */
    bool parameters_only; /* only theta: no test of convergence, no identifiability */
    int threads;          /* of the acceptance, as of mukca_workers_start */
} mukca_fit_options;

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
} mukca_fit;

/* Fit to `data`, from nominal.  Of more than MUKCA_MOST_SAMPLES samples, Hessian, rank and standard
 * errors are computed from so many: an approximate Hessian changes only the solver's steps, not the
 * minimum.  Errors: MUKCA_USAGE, MUKCA_INPUT, MUKCA_MEMORY, MUKCA_INTERRUPTED.
 * Failure to converge is a result, not an error. */
mukca_status mukca_fit_run(mukca_fit *fit, const mukca_chain *chain, const mukca_dataset *data,
                           const mukca_fit_options *options, mukca_error *error);

#endif
