/* The MUKCa cost and its gradient. */
#include "fit/cost.h"

#include <string.h>

bool mukca_cost_init(mukca_cost *cost, mukca_pool *pool, const mukca_chain *chain,
                     const mukca_parameters *parameters, const mukca_dataset *data,
                     const mukca_cost_options *options)
{
    double nominal[MUKCA_MAX_FREE];
    mukca_chain_theta(nominal, chain);
    const int n = parameters->n, all = MUKCA_PARAMETERS * chain->n_elements;
    memset(cost, 0, sizeof *cost);
    if (!mukca_observe_setup(&cost->observations, pool, chain, data)) return false;
    cost->theta = MUKCA_TAKE(pool, double, all);
    cost->nominal = MUKCA_TAKE(pool, double, n);
    if (pool->failed) return false;
    cost->parameters = cost->observations.parameters = parameters;
    cost->observations.kind = options->gradient;
    cost->n = n;
    cost->lambda = options->lambda < 0 ? 0 : options->lambda > 0 ? options->lambda : MUKCA_LAMBDA;
    memcpy(cost->theta, options->theta ? options->theta : nominal, (size_t)all * sizeof *nominal);
    mukca_parameters_pack(cost->nominal, parameters, nominal);
    return true;
}

double mukca_cost_evaluate(mukca_cost_value *parts, double *gradient, mukca_cost *cost,
                           const double *x)
{
    mukca_cost_value value = {0};
    mukca_observations *o = &cost->observations;
    const double lambda = mukca_cost_lambda(cost);
    cost->evaluations++;
    mukca_parameters_unpack(cost->theta, cost->parameters, x);
    mukca_observe_predict(o, cost->theta);
    value.inconsistency = mukca_observe_squares(&value.distortion, o, true);
    if (gradient) mukca_observe_gradient(gradient, o);
    for (int i = 0; i < cost->n; i++) {
        if (!cost->parameters->regularised[i]) continue;
        const double off = x[i] - cost->nominal[i];
        value.regularisation += lambda * off * off;
        if (gradient) gradient[i] += 2 * lambda * off;
    }
    if (cost->more) cost->more(&value, gradient, cost, x);
    value.total = value.inconsistency + value.distortion + value.regularisation;
    if (parts) *parts = value;
    return value.total;
}
