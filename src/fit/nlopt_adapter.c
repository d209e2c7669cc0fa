/* SLSQP and LBFGS of NLopt in whitened variables.
 *
 * x = x0 + s L^-T y with L L' half the Gauss-Newton Hessian at the start and s = sqrt(J0 / 2), so
 * that f(y) = J / J0 is of order one and its Hessian near the identity: without whitening LBFGS
 * converges slowly and stops at its built-in gradient tolerance.  Once J is far below J0 the
 * variables are whitened again at the best point so far, with the local metric, and f is of order
 * one again.
 */
#include "fit/nlopt_adapter.h"

#include <math.h>
#include <nlopt.h>
#include <string.h>

#include "base/clock.h"
#include "math/dense.h"

typedef struct {
    mukca_cost *cost;
    const mukca_solver_options *options;
    mukca_solver_outcome *outcome;
    nlopt_opt opt;
    double *L;         /* [n][n] */
    double *start;     /* [n] centre of the whitening */
    double *x, *g, *y; /* [n] scratch */
    double *best;      /* [n] best point seen */
    double best_value, scale, unit;
    int before;
    bool decided; /* outcome->stop is final */
    bool anew;    /* stopped for new whitening */
} adapter;

/* Decrease of the cost that triggers new whitening: at a tenth of the cost the residuals are a
 * third, and the metric depends more on the data than on the start. */
static const double fall = 0.1;

static void decide(adapter *a, mukca_stop stop)
{
    a->outcome->stop = stop;
    a->decided = true;
    nlopt_force_stop(a->opt);
}

static double objective(unsigned n_unsigned, const double *y, double *gradient, void *context)
{
    adapter *a = context;
    const int n = (int)n_unsigned;
    mukca_cost_value parts;
    if (a->options->stop && a->options->stop(a->options->context)) {
        decide(a, MUKCA_STOP_STOPPED);
        return HUGE_VAL;
    }
    memcpy(a->x, y, (size_t)n * sizeof *y);
    mukca_dense_backward(a->x, 1, a->L, n);
    for (int i = 0; i < n; i++) a->x[i] = a->start[i] + a->scale * a->x[i];
    const double value = mukca_cost_evaluate(&parts, gradient ? a->g : NULL, a->cost, a->x);
    double slope = 0;
    if (gradient) {
        memcpy(gradient, a->g, (size_t)n * sizeof *gradient);
        mukca_dense_forward(gradient, 1, a->L, n);
        for (int i = 0; i < n; i++) {
            gradient[i] *= a->scale / a->unit;
            slope += gradient[i] * gradient[i];
        }
    }
    if (!isfinite(value) || !isfinite(slope)) { /* NLopt does not stop at NaN */
        decide(a, MUKCA_STOP_NOT_FINITE);
        return HUGE_VAL;
    }
    if (value < a->best_value) {
        a->outcome->iterations += isfinite(a->best_value);
        a->best_value = value;
        memcpy(a->best, a->x, (size_t)n * sizeof *a->x);
        if (a->options->progress)
            a->options->progress(a->options->context, a->cost->theta, &parts,
                                 a->cost->evaluations - a->before);
    }
    if (gradient && slope / 2 * a->unit <= mukca_solver_goal(value)) {
        decide(a, MUKCA_STOP_GRADIENT);
    } else if (a->best_value < fall * a->unit) {
        a->anew = true;
        nlopt_force_stop(a->opt);
    }
    return value / a->unit;
}

static mukca_stop stop_of(nlopt_result result)
{
    if (result == NLOPT_MAXEVAL_REACHED || result == NLOPT_MAXTIME_REACHED) return MUKCA_STOP_LIMIT;
    return result > 0 || result == NLOPT_ROUNDOFF_LIMITED ? MUKCA_STOP_TOLERANCE
                                                          : MUKCA_STOP_FAILED;
}

/* One round: whiten at the best point, minimise from there. */
static mukca_status run_round(adapter *a, nlopt_algorithm algorithm, int max_evaluations,
                              double max_seconds, mukca_error *error)
{
    const int n = a->cost->n;
    double value = 0;
    mukca_cost_normal(a->L, a->cost, a->best, false);
    mukca_solver_factorise(a->L, n);
    memcpy(a->start, a->best, (size_t)n * sizeof *a->start);
    memset(a->y, 0, (size_t)n * sizeof *a->y);
    a->scale = sqrt(a->unit / 2);
    a->anew = false;
    a->opt = nlopt_create(algorithm, (unsigned)n);
    if (!a->opt)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for NLopt, %d parameters", n);
    nlopt_set_min_objective(a->opt, objective, a);
    nlopt_set_ftol_abs(a->opt, 1e-30);
    nlopt_set_maxeval(a->opt, max_evaluations);
    nlopt_set_maxtime(a->opt, max_seconds);
    const nlopt_result result = nlopt_optimize(a->opt, a->y, &value);
    nlopt_destroy(a->opt);
    if (result == NLOPT_OUT_OF_MEMORY)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory in NLopt, %d parameters", n);
    if (!a->decided && !a->anew) a->outcome->stop = stop_of(result);
    return MUKCA_OK;
}

static mukca_status run_nlopt(nlopt_algorithm algorithm, double *x, mukca_solver_outcome *outcome,
                              mukca_cost *cost, const mukca_solver_options *options,
                              mukca_error *error)
{
    const mukca_solver_options none = {0};
    const int n = cost->n;
    double *work = cost->scratch + 3 * n * n;
    mukca_status status = MUKCA_OK;
    const double until = mukca_clock_seconds() + MUKCA_SOLVER_SECONDS;
    adapter a = {.cost = cost,
                 .options = options ? options : &none,
                 .outcome = outcome,
                 .L = cost->scratch,
                 .x = work,
                 .g = work + n,
                 .start = work + 2 * n,
                 .y = work + 3 * n,
                 .best = x,
                 .best_value = HUGE_VAL,
                 .before = cost->evaluations};
    const int limit = a.options->max_evaluations > 0 ? a.options->max_evaluations : 2000;
    *outcome = (mukca_solver_outcome){.stop = MUKCA_STOP_NOT_FINITE};
    a.unit = mukca_cost_evaluate(NULL, NULL, cost, x);
    if (!isfinite(a.unit)) return MUKCA_OK;
    if (!(a.unit > 0)) a.unit = 1;
    do {
        const int left = limit - (cost->evaluations - a.before);
        const double seconds = until - mukca_clock_seconds();
        outcome->stop = MUKCA_STOP_LIMIT;
        if (left <= 0 || seconds <= 0) break;
        status = run_round(&a, algorithm, left, seconds, error);
        a.unit = a.best_value;
    } while (status == MUKCA_OK && a.anew && a.unit > 0);
    outcome->evaluations = cost->evaluations - a.before;
    return status;
}

static mukca_status run_slsqp(double *x, mukca_solver_outcome *outcome, mukca_cost *cost,
                              const mukca_solver_options *options, mukca_error *error)
{
    return run_nlopt(NLOPT_LD_SLSQP, x, outcome, cost, options, error);
}

static mukca_status run_lbfgs(double *x, mukca_solver_outcome *outcome, mukca_cost *cost,
                              const mukca_solver_options *options, mukca_error *error)
{
    return run_nlopt(NLOPT_LD_LBFGS, x, outcome, cost, options, error);
}

static const mukca_solver slsqp = {.name = "slsqp", .run = run_slsqp};
static const mukca_solver lbfgs = {.name = "lbfgs", .run = run_lbfgs};

const mukca_solver *const mukca_solver_table[] = {&slsqp, &lbfgs, &mukca_solver_gauss_newton, NULL};
