/* The cost with measured poses, its Gauss-Newton Hessian, held directions; damped Gauss-Newton, and
 * functions shared by all solvers. */
#include "fit/solver.h"

#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "fit/poses.h"
#include "math/dense.h"

static double along(const double *v, const double *x, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += v[i] * x[i];
    return sum;
}

/* Add measured orientations and held directions. */
static void add(mukca_cost_value *parts, double *gradient, mukca_cost *cost, const double *x)
{
    mukca_observations *o = &cost->observations;
    const double lambda = mukca_cost_lambda(cost);
    mukca_orientations_predict(o);
    parts->inconsistency += mukca_orientations_squares(o, true);
    if (gradient) mukca_orientations_gradient(gradient, o);
    for (int d = 0; d < cost->n_held; d++) {
        const double *v = cost->held + (size_t)(d * cost->n);
        const double off = along(v, x, cost->n) - cost->held_at[d];
        parts->regularisation += lambda * off * off;
        for (int i = 0; i < cost->n && gradient; i++) gradient[i] += 2 * lambda * off * v[i];
    }
}

/* Square roots of the weights of the residuals, weight[n_residuals]; 1 of pairs. */
static void set_weights(double *weight, const mukca_observations *o)
{
    for (int i = 0; i < o->n_rows; i++)
        for (int a = 0; a < 3; a++) {
            weight[3 * i + a] = sqrt(o->row_weight[i]);
            if (o->turn_weight) weight[3 * (o->n_rows + i) + a] = sqrt(o->turn_weight[i]);
        }
    for (int p = 0; p < o->n_pairs; p++) weight[(o->turn_weight ? 6 : 3) * o->n_rows + p] = 1;
}

bool mukca_cost_setup(mukca_cost *cost, mukca_pool *pool, const mukca_chain *chain,
                      const mukca_parameters *parameters, const mukca_dataset *data,
                      const mukca_cost_options *options)
{
    mukca_observations *o = &cost->observations;
    const int n = parameters->n;
    if (!mukca_cost_init(cost, pool, chain, parameters, data, options)) return false;
    if (!mukca_poses_add(o, pool, data, n)) return false;
    const int m = o->n_residuals;
    cost->more = add;
    cost->part = options->part ? options->part : cost;
    if (cost->part == cost) {
        cost->r = MUKCA_TAKE(pool, double, m);
        cost->J = MUKCA_TAKE(pool, double, m *n);
        cost->weight = MUKCA_TAKE(pool, double, m);
    }
    for (int i = 0; i < 3; i++) cost->matrix[i] = MUKCA_TAKE(pool, double, n *n);
    for (int i = 0; i < 4; i++) cost->vector[i] = MUKCA_TAKE(pool, double, n);
    cost->held = MUKCA_TAKE(pool, double, n *n);
    cost->held_at = MUKCA_TAKE(pool, double, n);
    if (pool->failed) return false;
    if (cost->part == cost) set_weights(cost->weight, o);
    return true;
}

void mukca_cost_hold(mukca_cost *cost, const double *x)
{
    int loose[MUKCA_MAX_FREE], k = 0;
    const int n = cost->n;
    const double lambda = mukca_cost_lambda(cost);
    double *H = cost->matrix[0], *A = cost->matrix[1], *V = cost->matrix[2],
           curvature[MUKCA_MAX_FREE];
    for (int i = 0; i < n; i++)
        if (!cost->parameters->regularised[i]) loose[k++] = i;
    if (k == 0 || !(lambda > 0)) return;
    mukca_cost_normal(H, cost, x, true);
    for (int i = 0; i < k * k; i++) A[i] = H[loose[i / k] * n + loose[i % k]];
    if (!mukca_dense_svd(A, curvature, V, k)) return;
    for (int d = 0; d < k; d++) {
        if (curvature[d] >= lambda) continue;
        double *v = cost->held + (size_t)(cost->n_held * n);
        memset(v, 0, (size_t)n * sizeof *v);
        for (int i = 0; i < k; i++) v[loose[i]] = V[i * k + d];
        cost->held_at[cost->n_held++] = along(v, x, n);
    }
}

void mukca_cost_normal(double *H, mukca_cost *cost, const double *x, bool data_only)
{
    mukca_cost *part = cost->part;
    const int n = cost->n, m = part->observations.n_residuals;
    const double lambda = mukca_cost_lambda(cost);
    mukca_parameters_unpack(part->theta, cost->parameters, x);
    mukca_observe_residuals(part->r, part->J, &part->observations, part->theta);
    for (int i = 0; i < m; i++)
        for (int c = 0; c < n; c++) part->J[i * n + c] *= part->weight[i];
    memset(H, 0, (size_t)(n * n) * sizeof *H);
    mukca_dense_syrk(H, n, part->J, m, n);
    for (int i = 0; i < n && !data_only; i++)
        if (cost->parameters->regularised[i]) H[i * n + i] += lambda;
    for (int d = 0; d < cost->n_held && !data_only; d++) {
        const double *v = cost->held + (size_t)(d * n);
        for (int i = 0; i < n * n; i++) H[i] += lambda * v[i / n] * v[i % n];
    }
}

/* ---- solvers ---- */

#define STOP_TEXT(name, text) text,
const char *const mukca_stop_text[] = {MUKCA_STOP_LIST(STOP_TEXT)};

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
    memcpy(work, gradient, (size_t)n * sizeof *work);
    return mukca_dense_variance(work, L, n) / 4;
}

static mukca_status run(double *x, mukca_solver_outcome *outcome, mukca_cost *cost,
                        const mukca_solver *solver, const mukca_solver_options *options,
                        mukca_error *error)
{
    const int n = cost->n;
    double *H = cost->matrix[0], *L = cost->matrix[1], *g = cost->vector[0],
           *step = cost->vector[1], *trial = cost->vector[2], *g_trial = cost->vector[3];
    double damping = 0, value;
    (void)solver, (void)error;
    const int limit = options->max_evaluations > 0 ? options->max_evaluations : 2000;
    const double until = mukca_clock_seconds() + MUKCA_SOLVER_SECONDS;
    const int before = cost->evaluations;
    memset(outcome, 0, sizeof *outcome);
    value = mukca_cost_evaluate(NULL, g, cost, x);
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
        const double next = mukca_cost_evaluate(NULL, g_trial, cost, trial);
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

const mukca_solver mukca_solver_gauss_newton = {.run = run};
