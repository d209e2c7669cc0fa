/* Simulated truth is found again: exactly without noise, and as the standard errors say with it. */
#include <stdlib.h>
#include <string.h>

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
    data->distances = calloc((size_t)placements, sizeof *data->distances);
    assert_non_null(data->distances);
    data->n_distances = placements;
    for (int s = 0, i = 0; s < 2 * placements; s++) {
        const double place[3] = {0.35 + 0.1 * (s / 2 % 2), 0.2 * (s / 2 % 3) - 0.2,
                                 0.3 + 0.12 * (s / 2 % 4)};
        data->sockets[s].placement = s / 2;
        data->distances[s / 2] = (mukca_distance){2 * (s / 2), 2 * (s / 2) + 1, 0.05};
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

static void perturb(double *theta, const mukca_chain *chain, double size, mukca_random *random)
{
    mukca_chain_theta(theta, chain);
    for (int i = 0; i < 6 * chain->n_elements; i++) theta[i] += size * mukca_random_normal(random);
}

/* Mean distance of the ball from the mean of its socket. */
static double consistency(const mukca_chain *chain, const double *theta, const mukca_dataset *data)
{
    mukca_geometry geometry;
    double sum = 0;
    mukca_geometry_set(&geometry, chain, theta);
    for (int s = 0; s < data->n_sockets; s++) {
        double x[PER_SOCKET][3], mean[3] = {0, 0, 0};
        int n = 0;
        for (int i = 0; i < data->n_rows; i++)
            if (data->socket[i] == s)
                mukca_fk_position(x[n++], &geometry, data->q + i * JOINTS, NULL);
        for (int i = 0; i < n; i++)
            for (int a = 0; a < 3; a++) mean[a] += x[i][a] / n;
        for (int i = 0; i < n; i++)
            sum += sqrt(pow(x[i][0] - mean[0], 2) + pow(x[i][1] - mean[1], 2) +
                        pow(x[i][2] - mean[2], 2));
    }
    return sum / data->n_rows;
}

TEST(test_without_noise)
{
    mukca_chain chain;
    mukca_random random;
    make_chain(&chain, "RRRRRRRF", origins, "j", 2.8);
    mukca_random_seed(&random, 21);
    for (int trial = 0; trial < 5; trial++) {
        double truth[MUKCA_MAX_FREE], nominal[MUKCA_MAX_FREE];
        mukca_dataset train, test;
        mukca_fit fit;
        perturb(truth, &chain, 2e-3, &random);
        record(&train, &chain, truth, 4, 0, &random);
        record(&test, &chain, truth, 6, 0, &random);
        mukca_chain_theta(nominal, &chain);
        const mukca_fit_options options = {.cost.lambda = trial < 4 ? 1e-9 : -1};
        assert_ok(mukca_fit_run(&fit, &chain, &train, &options, NULL));
        assert_true(fit.converged);
        assert_int_equal(fit.identification.rank,
                         25); /* 48 less 6 of the base, 14 of the axes, 3 */
        assert_true(consistency(&chain, nominal, &test) > 1e-3);
        assert_true(consistency(&chain, truth, &test) < 1e-11);
        assert_close(consistency(&chain, fit.theta, &test), 0, 1e-6);
        mukca_fit_free(&fit);
        mukca_dataset_free(&train);
        mukca_dataset_free(&test);
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
        mukca_random random;
        mukca_dataset data;
        mukca_fit fit;
        const mukca_fit_options options = {.selection.free = identifiable, .cost.lambda = -1};
        mukca_parameters free;
        mukca_random_seed(&random, 1000 + (uint64_t)seed);
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
        mukca_fit_free(&fit);
        mukca_dataset_free(&data);
    }
    print_message("mean z^2 %.4f over %d parameters, noise %.4g\n", total / parameters, parameters,
                  noise);
    assert_close(total / parameters, 1, 0.05);
    assert_close(noise, sigma, 0.01 * sigma);
    for (int i = 0; i < parameters; i++)
        assert_close(squares[i], 1, 0.4); /* 4 sigma of chi2(200)/200 */
}

TEST_MAIN(NULL, NULL)
