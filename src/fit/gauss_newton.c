/* Damped Gauss-Newton, and functions shared by all solvers. */
#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "fit/solver.h"
#include "math/dense.h"

const char *mukca_stop_text(mukca_stop stop)
{
    static const char *const text[] = {
#define STOP_TEXT(name, text) text,
        MUKCA_STOP_LIST(STOP_TEXT)
#undef STOP_TEXT
    };
    return text[stop];
}

double mukca_solver_goal(double cost)
{
    return 1e-10 * cost + 1e-24;
}

static double largest_diagonal(const double *H, int n)
{
    double largest = 0;
    for (int i = 0; i < n; i++) largest = fmax(largest, H[i * n + i]);
    return largest > 0 ? largest : 1;
}

void mukca_solver_factorise(double *H, int n)
{
    double ridge = 1e-12 * largest_diagonal(H, n);
    for (int i = 0; i < n; i++) H[i * n + i] += ridge;
    mukca_dense_cholesky(H, n);
}

double mukca_solver_decrement(const double *L, const double *gradient, double *work, int n)
{
    double sum = 0;
    memcpy(work, gradient, (size_t)n * sizeof *work);
    mukca_dense_forward(work, 1, L, n);
    for (int i = 0; i < n; i++) sum += work[i] * work[i];
    return sum / 4;
}

static mukca_status run(double *x, mukca_solver_outcome *outcome, mukca_cost *cost,
                        const mukca_solver *solver, const mukca_solver_options *options,
                        mukca_error *error)
{
    const int n = cost->n;
    double *H = cost->scratch, *L = H + n * n, *g = H + 3 * n * n, *step = g + n, *trial = step + n,
           *g_trial = trial + n;
    double damping = 0, value;
    mukca_cost_value parts;
    (void)solver, (void)error;
    const int limit = options->max_evaluations > 0 ? options->max_evaluations : 2000;
    const double until = mukca_clock_seconds() + MUKCA_SOLVER_SECONDS;
    const int before = cost->evaluations;
    memset(outcome, 0, sizeof *outcome);
    value = mukca_cost_evaluate(&parts, g, cost, x);
    outcome->stop = isfinite(value) ? MUKCA_STOP_LIMIT : MUKCA_STOP_NOT_FINITE;
    bool moved = true;
    while (outcome->stop == MUKCA_STOP_LIMIT && cost->evaluations - before < limit &&
           mukca_clock_seconds() < until) {
        if (options->stop && options->stop(options->context)) {
            outcome->stop = MUKCA_STOP_STOPPED;
            break;
        }
        if (moved) mukca_cost_normal(H, cost, x, false);
        memcpy(L, H, (size_t)(n * n) * sizeof *L);
        for (int i = 0; i < n; i++) L[i * n + i] += damping;
        mukca_solver_factorise(L, n);
        const double promised = mukca_solver_decrement(L, g, step, n);
        if (promised <= mukca_solver_goal(value)) {
            outcome->stop = MUKCA_STOP_GRADIENT;
            break;
        }
        mukca_dense_backward(step, 1, L, n);
        for (int i = 0; i < n; i++) trial[i] = x[i] - step[i] / 2;
        const double next = mukca_cost_evaluate(&parts, g_trial, cost, trial);
        moved = next < value;
        if (!moved) {
            if (promised <= 1e-9 * value) { /* at the limit of rounding */
                outcome->stop = MUKCA_STOP_TOLERANCE;
                break;
            }
            damping = fmax(10 * damping, 1e-8 * largest_diagonal(H, n));
            if (!isfinite(damping)) outcome->stop = MUKCA_STOP_FAILED;
            continue;
        }
        damping = damping > 1e-8 * largest_diagonal(H, n) ? damping / 10 : 0;
        outcome->iterations++;
        memcpy(x, trial, (size_t)n * sizeof *x);
        memcpy(g, g_trial, (size_t)n * sizeof *g);
        value = next;
    }
    outcome->evaluations = cost->evaluations - before;
    return MUKCA_OK;
}

const mukca_solver mukca_solver_gauss_newton = {.name = "gauss-newton", .run = run};
