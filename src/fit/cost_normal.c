/* The cost with measured poses, its Gauss-Newton Hessian, held directions. */
#include "fit/solver.h"

#include <string.h>

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
    if (gradient)
        mukca_orientations_gradient(gradient, o, cost->theta, cost->parameters, cost->gradient);
    for (int d = 0; d < cost->n_held; d++) {
        const double *v = cost->held + (size_t)(d * cost->n);
        const double off = along(v, x, cost->n) - cost->held_at[d];
        parts->regularisation += lambda * off * off;
        for (int i = 0; i < cost->n && gradient; i++) gradient[i] += 2 * lambda * off * v[i];
    }
}

bool mukca_cost_setup(mukca_cost *cost, mukca_pool *pool, const mukca_chain *chain,
                      const mukca_parameters *parameters, const mukca_dataset *data,
                      const mukca_cost_options *options)
{
    mukca_observations *o = &cost->observations;
    const int n = parameters->n;
    if (!mukca_cost_init(cost, pool, chain, parameters, data, options)) return false;
    if (!mukca_poses_add(o, pool, data)) return false;
    const int m = o->n_residuals;
    cost->more = add;
    cost->part = options->part ? options->part : cost;
    if (cost->part == cost) {
        cost->r = MUKCA_TAKE(pool, double, m);
        cost->J = MUKCA_TAKE(pool, double, m *n);
        cost->weight = MUKCA_TAKE(pool, double, m);
    }
    cost->scratch = MUKCA_TAKE(pool, double, 3 * n * n + 6 * n);
    cost->held = MUKCA_TAKE(pool, double, n *n);
    cost->held_at = MUKCA_TAKE(pool, double, n);
    if (pool->failed) return false;
    if (cost->part == cost) mukca_observe_weights(cost->weight, o);
    return true;
}

void mukca_cost_hold(mukca_cost *cost, const double *x)
{
    int loose[MUKCA_MAX_FREE], k = 0;
    const int n = cost->n;
    const double lambda = mukca_cost_lambda(cost);
    double *H = cost->scratch, *A = H + n * n, *V = A + n * n, curvature[MUKCA_MAX_FREE];
    for (int i = 0; i < n; i++)
        if (!cost->parameters->regularised[i]) loose[k++] = i;
    if (k == 0 || !(lambda > 0)) return;
    mukca_cost_normal(H, cost, x, true);
    for (int i = 0; i < k * k; i++) A[i] = H[loose[i / k] * n + loose[i % k]];
    if (mukca_dense_svd(A, curvature, V, k) != 0) return;
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
    mukca_observe_residuals(part->r, part->J, &part->observations, part->theta, cost->parameters,
                            cost->gradient);
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
