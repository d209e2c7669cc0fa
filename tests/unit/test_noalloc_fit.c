/* Kinematics, cost, gradient and Hessian allocate nothing; the linker wraps the allocator. */
#include "close.h"
#include "fit/cost.h"
#include "fit/fit.h"
#include "fit/solver.h"
#include "gen3.h"
#include "math/random.h"
#include "noalloc.h"

TEST(test_nothing_allocated)
{
    enum { ROWS = 60 };
    mukca_chain chain;
    mukca_dataset data;
    mukca_parameters parameters;
    mukca_cost cost;
    mukca_random random = mukca_random_seeded(6);
    mukca_solver_outcome outcome;
    double x[MUKCA_MAX_FREE], g[MUKCA_MAX_FREE], position[3], J[6 * 7], sum = 0;
    gen3_chain(&chain);
    assert_ok(mukca_dataset_create(&data, ROWS, 7, 2, 1, NULL));
    data.distances = zeroed(1, sizeof *data.distances);
    data.n_distances = 1;
    data.distances[0] = (mukca_distance){.a = 0, .b = 1, .distance = 0.05};
    for (int i = 0; i < ROWS; i++) data.socket[i] = i % 2;
    for (int i = 0; i < 7 * ROWS; i++) data.q[i] = mukca_random_normal(&random);
    assert_ok(mukca_parameters_select(&parameters, &chain, &(mukca_selection){0}, NULL));
    mukca_pool pool = {0};
    assert_true(
        mukca_cost_setup(&cost, &pool, &chain, &parameters, &data, &(mukca_cost_options){0}));
    assert_true(calls > 0); /* the wrapping works */
    calls = 0;
    memcpy(x, cost.nominal, (size_t)cost.n * sizeof *x);
    sum += mukca_cost_evaluate(NULL, NULL, &cost, x);
    sum += mukca_cost_evaluate(NULL, g, &cost, x);
    cost.observations.kind = MUKCA_GRADIENT_ANALYTIC;
    sum += mukca_cost_evaluate(NULL, g, &cost, x);
    mukca_cost_normal(cost.matrix[0], &cost, x, false);
    mukca_solver_gauss_newton.run(x, &outcome, &cost, NULL, &(mukca_solver_options){0}, NULL);
    mukca_geometry geometry;
    mukca_geometry_set(&geometry, &chain, cost.theta);
    mukca_fk_position(position, &geometry, data.q, NULL);
    mukca_fk_jacobian(J, NULL, &geometry, data.q, NULL);
    assert_int_equal(calls, 0);
    assert_true(isfinite(sum));
    assert_true(outcome.iterations > 0);
    mukca_pool_free(&pool);
    mukca_dataset_free(&data);
}

TEST_MAIN(NULL, NULL)
