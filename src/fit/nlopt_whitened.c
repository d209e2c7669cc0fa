/* SLSQP and LBFGS of NLopt in whitened variables, and the table of solvers.
 *
 * x = x0 + s L^-T y with L L' half the Gauss-Newton Hessian at the start and s = sqrt(J0 / 2), so
 * that f(y) = J / J0 is of order one and its Hessian near the identity: without whitening LBFGS
 * converges slowly and stops at its built-in gradient tolerance.  Once J is far below J0 the
 * variables are whitened again at the best point so far, with the local metric, and f is of order
 * one again.
 */
#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "fit/nlopt_adapter.h"
#include "fit/solver.h"
#include "math/dense.h"

typedef struct {
    mukca_cost *cost;
    const mukca_solver_options *options;
    mukca_solver_outcome *outcome;
    double *L;         /* [n][n] */
    double *start;     /* [n] centre of the whitening */
    double *x, *g, *y; /* [n] scratch */
    double *best;      /* [n] best point seen */
    double best_value, scale, unit;
    bool decided; /* outcome->stop is final */
    bool anew;    /* stopped for new whitening */
} whitened;

/* Decrease of the cost that triggers new whitening: at a tenth of the cost the residuals are a
 * third, and the metric depends more on the data than on the start. */
static const double fall = 0.1;

static double decide(whitened *a, mukca_stop stop, bool *halt)
{
    a->outcome->stop = stop;
    a->decided = *halt = true;
    return HUGE_VAL;
}

static double objective(void *context, double *gradient, const double *y, bool *halt)
{
    whitened *a = context;
    const int n = a->cost->n;
    if (a->options->stop && a->options->stop(a->options->context))
        return decide(a, MUKCA_STOP_STOPPED, halt);
    memcpy(a->x, y, (size_t)n * sizeof *y);
    mukca_dense_backward(a->x, 1, a->L, n);
    for (int i = 0; i < n; i++) a->x[i] = a->start[i] + a->scale * a->x[i];
    const double value = mukca_cost_evaluate(NULL, gradient ? a->g : NULL, a->cost, a->x);
    double slope = 0;
    if (gradient) {
        memcpy(gradient, a->g, (size_t)n * sizeof *gradient);
        mukca_dense_forward(gradient, 1, a->L, n);
        for (int i = 0; i < n; i++) {
            gradient[i] *= a->scale / a->unit;
            slope += gradient[i] * gradient[i];
        }
    }
    if (!isfinite(value) || !isfinite(slope)) /* NLopt does not stop at NaN */
        return decide(a, MUKCA_STOP_NOT_FINITE, halt);
    if (value < a->best_value) {
        a->outcome->iterations += isfinite(a->best_value);
        a->best_value = value;
        memcpy(a->best, a->x, (size_t)n * sizeof *a->x);
    }
    if (gradient && slope / 2 * a->unit <= mukca_solver_goal(value))
        decide(a, MUKCA_STOP_GRADIENT, halt);
    else if (a->best_value < fall * a->unit)
        a->anew = *halt = true;
    return value / a->unit;
}

/* One round: whiten at the best point, minimise from there. */
static mukca_status run_round(whitened *a, mukca_nlopt_method method, int max_evaluations,
                              double max_seconds, mukca_error *error)
{
    const int n = a->cost->n;
    const mukca_nlopt_problem problem = {objective, a, n, max_evaluations, max_seconds};
    mukca_stop stop;
    mukca_cost_normal(a->L, a->cost, a->best, false);
    mukca_solver_factorise(a->L, n);
    memcpy(a->start, a->best, (size_t)n * sizeof *a->start);
    memset(a->y, 0, (size_t)n * sizeof *a->y);
    a->scale = sqrt(a->unit / 2);
    a->anew = false;
    const mukca_status status = mukca_nlopt_minimise(a->y, &stop, &problem, method, error);
    if (!a->decided && !a->anew) a->outcome->stop = stop;
    return status;
}

static mukca_status run(double *x, mukca_solver_outcome *outcome, mukca_cost *cost,
                        const mukca_solver *solver, const mukca_solver_options *options,
                        mukca_error *error)
{
    mukca_status status = MUKCA_OK;
    const double until = mukca_clock_seconds() + MUKCA_SOLVER_SECONDS;
    whitened a = {.cost = cost,
                  .options = options,
                  .outcome = outcome,
                  .L = cost->matrix[0],
                  .x = cost->vector[0],
                  .g = cost->vector[1],
                  .start = cost->vector[2],
                  .y = cost->vector[3],
                  .best = x,
                  .best_value = HUGE_VAL};
    const int limit = options->max_evaluations > 0 ? options->max_evaluations : 2000;
    const int before = cost->evaluations;
    *outcome = (mukca_solver_outcome){.stop = MUKCA_STOP_NOT_FINITE};
    a.unit = mukca_cost_evaluate(NULL, NULL, cost, x);
    if (!isfinite(a.unit)) return MUKCA_OK;
    if (!(a.unit > 0)) a.unit = 1;
    do {
        const int left = limit - (cost->evaluations - before);
        const double seconds = until - mukca_clock_seconds();
        outcome->stop = MUKCA_STOP_LIMIT;
        if (left <= 0 || seconds <= 0) break;
        status = run_round(&a, solver->method, left, seconds, error);
        a.unit = a.best_value;
    } while (status == MUKCA_OK && a.anew && a.unit > 0);
    outcome->evaluations = cost->evaluations - before;
    return status;
}

static const mukca_solver slsqp = {MUKCA_NLOPT_SLSQP, run};
static const mukca_solver lbfgs = {MUKCA_NLOPT_LBFGS, run};

#define SOLVERS(X)     \
    X("slsqp", &slsqp) \
    X("lbfgs", &lbfgs) \
    X("gauss-newton", &mukca_solver_gauss_newton)
#define SOLVER(name, solver) solver,
#define NAME(name, solver) name,
const mukca_solver *const mukca_solver_table[] = {SOLVERS(SOLVER) NULL};
const char *const mukca_solver_name[] = {SOLVERS(NAME) NULL};
