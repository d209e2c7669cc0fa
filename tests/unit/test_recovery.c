/* Simulated truth is found again, as far off as the standard errors say. */
#include "arm/inverse.h"
#include "arms.h"
#include "close.h"
#include "fit/fit.h"
#include "math/random.h"
#include "math/stats.h"

enum { JOINTS = 7, PER_SOCKET = 30 };

/* A 7-axis arm with offsets in elbow and wrist and a ball well off the last axis. */
static const double origins[8][6] = {
    {0, 0, 0.3, 0, 0, 0},       {0, 0, 0, -M_PI_2, 0, 0},        {0, -0.37, 0, M_PI_2, 0, 0},
    {0.06, 0, 0, M_PI_2, 0, 0}, {-0.06, 0.35, 0, -M_PI_2, 0, 0}, {0, 0, 0, M_PI_2, 0, 0},
    {0.08, 0, 0, M_PI_2, 0, 0}, {0.09, 0.05, 0.14, 0, 0, 0}};

/* Postures of the arm `truth` with its ball in two sockets 50 mm apart at each of `placements`
 * places; every seat is off by noise of `sigma` m per coordinate. */
static void record(mukca_dataset *data, const mukca_chain *chain, const double *truth,
                   int placements, double sigma, mukca_random *random)
{
    mukca_geometry geometry;
    mukca_geometry_set(&geometry, chain, truth);
    assert_ok(mukca_dataset_create(data, 2 * PER_SOCKET * placements, JOINTS, 2 * placements,
                                   placements, NULL));
    data->distances = zeroed((size_t)placements, sizeof *data->distances);
    data->n_distances = placements;
    for (int s = 0, i = 0; s < 2 * placements; s++) {
        const double place[3] = {0.35 + 0.1 * (s / 2 % 2), 0.2 * (s / 2 % 3) - 0.2,
                                 0.3 + 0.12 * (s / 2 % 4)};
        data->sockets[s].placement = s / 2;
        data->distances[s / 2] =
            (mukca_distance){.a = s / 2 * 2, .b = s / 2 * 2 + 1, .distance = 0.05};
        for (int row = 0; row < PER_SOCKET;) {
            mukca_frame target = {{0}, {0}};
            double *q = data->q + i * JOINTS;
            memcpy(target.p, place, sizeof place);
            target.p[1] += s % 2 ? 0.05 : 0;
            for (int a = 0; a < 3; a++) target.p[a] += sigma * mukca_random_normal(random);
            for (int j = 0; j < JOINTS; j++) q[j] = 2.4 * (2 * mukca_random_uniform(random) - 1);
            const mukca_inverse_options options = {.tolerance = 1e-12};
            if (!mukca_inverse_solve(q, chain, &geometry, &target, false, &options).reached)
                continue;
            data->socket[i++] = s;
            row++;
        }
    }
}

/* A set of parameters that sockets can tell apart: no base, and per axis one slide along it and one
 * turn about it. */
static const char identifiable[] =
    "j2.x,j2.roll,j3.x,j3.z,j3.roll,j3.yaw,j4.x,j4.z,j4.roll,j4.yaw,j5.x,j5.z,j5.roll,j5.yaw,"
    "j6.x,j6.z,j6.roll,j6.yaw,j7.x,j7.z,j7.roll,j7.yaw,j8.x,j8.y,j8.z";

TEST(test_standard_errors)
{
    enum { SEEDS = 200 };
    const double sigma = 1e-4;
    mukca_chain chain;
    double squares[MUKCA_MAX_FREE] = {0}, total = 0, noise = 0;
    int parameters = 0;
    make_chain(&chain, "RRRRRRRF", origins, "j", 2.8);
    for (int seed = 0; seed < SEEDS; seed++) {
        double truth[MUKCA_MAX_FREE], nominal[MUKCA_MAX_FREE];
        mukca_random random = mukca_random_seeded(1000 + (uint64_t)seed);
        mukca_dataset data;
        mukca_fit fit;
        const mukca_fit_options options = {.selection.free = identifiable, .cost.lambda = -1};
        mukca_parameters free;
        mukca_chain_theta(nominal, &chain);
        memcpy(truth, nominal, sizeof truth);
        assert_ok(mukca_parameters_select(&free, &chain, &options.selection, NULL));
        for (int i = 0; i < free.n; i++)
            truth[free.index[i]] += 1e-3 * mukca_random_normal(&random);
        record(&data, &chain, truth, 3, sigma, &random);
        assert_ok(mukca_fit_run(&fit, &chain, &data, &options, NULL));
        assert_true(fit.converged);
        assert_int_equal(fit.identification.rank, free.n);
        for (int i = 0; i < free.n; i++) {
            assert_true(fit.identification.identifiable[i]);
            const double z =
                (fit.theta[free.index[i]] - truth[free.index[i]]) / fit.identification.sigma[i];
            squares[i] += z * z / SEEDS;
            total += z * z / SEEDS;
        }
        parameters = free.n;
        noise += fit.identification.noise / SEEDS;
        mukca_dataset_free(&data);
    }
    assert_close(total / parameters, 1, 0.05);
    assert_close(noise, sigma, 0.01 * sigma);
    for (int i = 0; i < parameters; i++)
        assert_close(squares[i], 1, 0.4); /* 4 sigma of chi2(200)/200 */
}

TEST_MAIN(NULL, NULL)
