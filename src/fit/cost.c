/* The MUKCa cost, its gradient and its Gauss-Newton Hessian. */
#include "fit/cost.h"

#include <string.h>

#include "math/dense.h"

bool mukca_cost_setup(mukca_cost *cost, mukca_pool *pool, const mukca_chain *chain,
                      const mukca_parameters *parameters, const mukca_dataset *data,
                      const mukca_cost_options *options)
{
    const mukca_cost_options none = {0};
    double nominal[MUKCA_MAX_FREE];
    if (!options) options = &none;
    mukca_chain_theta(nominal, chain);
    const double *fixed = options->nominal_means ? nominal : NULL;
    const int n = parameters->n, all = MUKCA_PARAMETERS * chain->n_elements;
    memset(cost, 0, sizeof *cost);
    if (!mukca_observe_setup(&cost->observations, pool, chain, data, fixed, n)) return false;
    const int m = cost->observations.n_residuals;
    cost->theta = MUKCA_TAKE(pool, double, all);
    cost->nominal = MUKCA_TAKE(pool, double, n);
    if (!options->part) {
        cost->r = MUKCA_TAKE(pool, double, m);
        cost->J = MUKCA_TAKE(pool, double, m *n);
        cost->weight = MUKCA_TAKE(pool, double, m);
    }
    cost->scratch = MUKCA_TAKE(pool, double, 3 * n * n + 6 * n);
    cost->held = MUKCA_TAKE(pool, double, n *n);
    cost->held_at = MUKCA_TAKE(pool, double, n);
    if (pool->failed) return false;

    cost->part = options->part ? options->part : cost;
    cost->parameters = parameters;
    cost->gradient = options->gradient;
    cost->n = n;
    cost->pair_weight = options->no_distortion ? 0 : 1;
    cost->lambda = options->lambda < 0 ? 0 : options->lambda > 0 ? options->lambda : MUKCA_LAMBDA;
    cost->lambda *= cost->observations.n_groups;
    memcpy(cost->theta, options->theta ? options->theta : nominal, (size_t)all * sizeof *nominal);
    mukca_parameters_pack(cost->nominal, parameters, nominal);
    if (!options->part) mukca_observe_weights(cost->weight, &cost->observations, cost->pair_weight);
    return true;
}

static double along(const double *v, const double *x, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += v[i] * x[i];
    return sum;
}

void mukca_cost_hold(mukca_cost *cost, const double *x)
{
    int loose[MUKCA_MAX_FREE], k = 0;
    const int n = cost->n;
    double *H = cost->scratch, *A = H + n * n, *V = A + n * n, curvature[MUKCA_MAX_FREE];
    for (int i = 0; i < n; i++)
        if (!cost->parameters->regularised[i]) loose[k++] = i;
    if (k == 0 || !(cost->lambda > 0)) return;
    mukca_cost_normal(H, cost, x, true);
    for (int i = 0; i < k * k; i++) A[i] = H[loose[i / k] * n + loose[i % k]];
    if (mukca_dense_svd(A, curvature, V, k, k) != 0) return;
    for (int d = 0; d < k; d++) {
        if (curvature[d] >= cost->lambda) continue;
        double *v = cost->held + (size_t)(cost->n_held * n);
        memset(v, 0, (size_t)n * sizeof *v);
        for (int i = 0; i < k; i++) v[loose[i]] = V[i * k + d];
        cost->held_at[cost->n_held++] = along(v, x, n);
    }
}

double mukca_cost_evaluate(mukca_cost_value *parts, double *gradient, mukca_cost *cost,
                           const double *x)
{
    mukca_cost_value value = {0};
    mukca_observations *o = &cost->observations;
    cost->evaluations++;
    mukca_parameters_unpack(cost->theta, cost->parameters, x);
    mukca_observe_predict(o, cost->theta);
    value.inconsistency = mukca_observe_squares(&value.distortion, o, true);
    value.distortion *= cost->pair_weight;
    if (gradient)
        mukca_observe_gradient(gradient, o, cost->theta, cost->parameters, cost->gradient,
                               cost->pair_weight);
    for (int i = 0; i < cost->n; i++) {
        if (!cost->parameters->regularised[i]) continue;
        const double off = x[i] - cost->nominal[i];
        value.regularisation += cost->lambda * off * off;
        if (gradient) gradient[i] += 2 * cost->lambda * off;
    }
    for (int d = 0; d < cost->n_held; d++) {
        const double *v = cost->held + (size_t)(d * cost->n);
        const double off = along(v, x, cost->n) - cost->held_at[d];
        value.regularisation += cost->lambda * off * off;
        for (int i = 0; i < cost->n && gradient; i++) gradient[i] += 2 * cost->lambda * off * v[i];
    }
    value.total = value.inconsistency + value.distortion + value.regularisation;
    if (parts) *parts = value;
    return value.total;
}

void mukca_cost_normal(double *H, mukca_cost *cost, const double *x, bool data_only)
{
    mukca_cost *part = cost->part;
    const int n = cost->n, m = part->observations.n_residuals;
    mukca_parameters_unpack(part->theta, cost->parameters, x);
    mukca_observe_residuals(part->r, part->J, &part->observations, part->theta, cost->parameters,
                            cost->gradient);
    for (int i = 0; i < m; i++)
        for (int c = 0; c < n; c++) part->J[i * n + c] *= part->weight[i];
    memset(H, 0, (size_t)(n * n) * sizeof *H);
    mukca_dense_syrk(H, n, part->J, m, n);
    for (int i = 0; i < n && !data_only; i++)
        if (cost->parameters->regularised[i]) H[i * n + i] += cost->lambda;
    for (int d = 0; d < cost->n_held && !data_only; d++) {
        const double *v = cost->held + (size_t)(d * n);
        for (int i = 0; i < n * n; i++) H[i] += cost->lambda * v[i / n] * v[i % n];
    }
}
