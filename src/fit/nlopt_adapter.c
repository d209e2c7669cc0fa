/* SLSQP and LBFGS of the NLopt library.  The only file that uses it. */
#include "fit/nlopt_adapter.h"

#include <nlopt.h>

typedef struct {
    const mukca_nlopt_problem *problem;
    nlopt_opt opt;
} adapter;

static double objective(unsigned n, const double *y, double *gradient, void *context)
{
    adapter *a = context;
    bool halt = false;
    const double value = a->problem->value(a->problem->context, gradient, y, &halt);
    (void)n;
    if (halt) nlopt_force_stop(a->opt);
    return value;
}

static mukca_stop stop_of(nlopt_result result)
{
    if (result == NLOPT_FORCED_STOP) return MUKCA_STOP_STOPPED;
    if (result == NLOPT_MAXEVAL_REACHED || result == NLOPT_MAXTIME_REACHED) return MUKCA_STOP_LIMIT;
    return result > 0 || result == NLOPT_ROUNDOFF_LIMITED ? MUKCA_STOP_TOLERANCE
                                                          : MUKCA_STOP_FAILED;
}

mukca_status mukca_nlopt_minimise(double *y, mukca_stop *stop, const mukca_nlopt_problem *problem,
                                  mukca_nlopt_method method, mukca_error *error)
{
    const nlopt_algorithm algorithm = method == MUKCA_NLOPT_LBFGS ? NLOPT_LD_LBFGS : NLOPT_LD_SLSQP;
    adapter a = {problem, nlopt_create(algorithm, (unsigned)problem->n)};
    double value = 0;
    nlopt_result result = NLOPT_OUT_OF_MEMORY;
    if (a.opt) {
        nlopt_set_min_objective(a.opt, objective, &a);
        nlopt_set_ftol_rel(a.opt, 1e-14);
        nlopt_set_maxeval(a.opt, problem->max_evaluations);
        nlopt_set_maxtime(a.opt, problem->max_seconds);
        result = nlopt_optimize(a.opt, y, &value);
        nlopt_destroy(a.opt);
    }
    *stop = stop_of(result);
    if (result == NLOPT_OUT_OF_MEMORY)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory in NLopt, %d parameters", problem->n);
    return MUKCA_OK;
}
