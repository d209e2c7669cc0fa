/* Traits of a model from its fleet. */
#include "fleet/traits.h"

#include <math.h>
#include <string.h>

static void list_traits(mukca_traits *t, const mukca_fleet_result *r)
{
    const mukca_population *p = &r->population;
    for (int k = 0; k < p->n; k++)
        t->list[t->n++] = (mukca_trait){.effect = mukca_fleet_term(p->term[k], t->model.n_joints),
                                        .mean = p->mean[k],
                                        .error = sqrt(p->covariance[k * p->n + k]),
                                        .spread = p->spread[k],
                                        .value = p->value[k],
                                        .low = p->low[k],
                                        .high = p->high[k],
                                        .arms = p->arms[k],
                                        .log_bayes_factor = p->log_bayes_factor[k],
                                        .probability = p->probability[k]};
    for (int j = 0; j < t->model.n_joints; j++)
        if (r->order[j].probability >= MUKCA_SHARED) t->list[t->n++] = r->order[j];
}

mukca_status mukca_fleet_pool(mukca_fleet_result *r, mukca_fleet *f, mukca_error *error)
{
    memset(r, 0, sizeof *r);
    if (f->n_arms < 2)
        return mukca_fail(error, MUKCA_INPUT,
                          "%s: the only arm ('%s'); a fleet needs two arms or more (label the "
                          "sessions with diagnose --arm)",
                          f->session[0].path, f->arm[0].name);
    bool ok = mukca_population_fit(&r->population, f, -1, false), any = false;
    const int n = r->population.n;
    r->departure = MUKCA_TAKE(&r->pool, mukca_departure, f->n_arms);
    r->estimate = MUKCA_TAKE(&r->pool, mukca_departure, (size_t)f->n_arms * (size_t)(n + 1));
    ok = ok && !r->pool.failed &&
         mukca_departures_find(r->departure, r->estimate, &r->population, f);
    for (int a = 0; a < f->n_arms && ok; a++)
        any |= f->arm[a].departs = r->departure[a].probability >= MUKCA_DEPARTS;
    if (any) /* a broken arm has no information on its sisters */
        ok = mukca_population_fit(&r->population, f, -1, true) &&
             mukca_departures_find(r->departure, r->estimate, &r->population, f);
    if (!ok) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d arms", f->n_arms);
    mukca_orders_pool(r->order, f);
    mukca_traits *t = &r->traits;
    t->model = f->model;
    t->n_arms = f->n_arms, t->n_sessions = f->n_sessions;
    for (int a = 0; a < f->n_arms; a++) t->n_samples += f->arm[a].samples;
    list_traits(t, r);
    return MUKCA_OK;
}

void mukca_fleet_result_free(mukca_fleet_result *r)
{
    mukca_pool_free(&r->pool);
    memset(r, 0, sizeof *r);
}
