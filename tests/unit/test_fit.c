/* Free and frozen parameters, solvers and their verdict, measured poses, what the data can tell. */
#include <stdlib.h>
#include <string.h>

#include "close.h"
#include "fit/fit.h"
#include "fit/solver.h"
#include "math/random.h"
#include "model/dataset_subset.h"

enum { JOINTS = 6 };

/* A 6-axis arm (all axes z in their frames) with a fixed tip. */
static void make_arm(mukca_chain *chain)
{
    static const double origin[7][6] = {{0, 0, 0.16, 0, 0, 0},      {0.05, 0, 0, M_PI_2, 0, 0},
                                        {-0.42, 0, 0, 0, 0, 0},     {-0.39, 0, 0.13, 0, 0, 0},
                                        {0, -0.1, 0, M_PI_2, 0, 0}, {0, 0.1, 0, -M_PI_2, 0, 0},
                                        {0.03, 0.04, 0.1, 0, 0, 0}};
    memset(chain, 0, sizeof *chain);
    chain->n_elements = 7;
    chain->n_joints = JOINTS;
    for (int k = 0; k < 7; k++) {
        mukca_element *e = &chain->element[k];
        snprintf(e->name, sizeof e->name, k < JOINTS ? "joint_%d" : "tip_joint", k + 1);
        e->type = k < JOINTS ? MUKCA_REVOLUTE : MUKCA_FIXED;
        e->joint = k < JOINTS ? k : -1;
        e->axis[2] = 1;
        memcpy(e->xyz, origin[k], sizeof e->xyz);
        memcpy(e->rpy, origin[k] + 3, sizeof e->rpy);
        if (k < JOINTS) chain->joint_element[k] = k;
    }
}

static int count_free(const mukca_chain *chain, const char *list, const char *freeze)
{
    mukca_parameters p;
    mukca_error error;
    const mukca_selection selection = {list, freeze, false};
    const mukca_status status = mukca_parameters_select(&p, chain, &selection, &error);
    if (status != MUKCA_OK) {
        assert_int_equal(status, MUKCA_USAGE);
        assert_true(strlen(error.text) > 20);
        return -1;
    }
    for (int i = 1; i < p.n; i++) assert_true(p.index[i] > p.index[i - 1]);
    return p.n;
}

static void test_selection(void **state)
{
    (void)state;
    mukca_chain chain;
    mukca_parameters p;
    make_arm(&chain);
    assert_int_equal(count_free(&chain, NULL, NULL), 42);
    assert_int_equal(count_free(&chain, "joint_2", NULL), 6);
    assert_int_equal(count_free(&chain, "joint_2.yaw,joint_2.x", NULL), 2);
    assert_int_equal(count_free(&chain, "yaw", NULL), 7);
    assert_int_equal(count_free(&chain, "yaw,joint_1", "joint_1.roll"), 11);
    assert_int_equal(count_free(&chain, NULL, "tip_joint,x,y,z"), 18);
    assert_int_equal(count_free(&chain, "joint_9", NULL), -1);
    assert_int_equal(count_free(&chain, "joint_2.w", NULL), -1);
    assert_int_equal(count_free(&chain, "joint_1,,x", NULL), -1);
    assert_int_equal(count_free(&chain, "", NULL), -1);
    assert_int_equal(count_free(&chain, NULL, "x,y,z,roll,pitch,yaw"), -1);

    /* a fixed joint in between stays, unless it is asked for */
    chain.element[2].type = MUKCA_FIXED;
    assert_int_equal(count_free(&chain, NULL, NULL), 36);
    assert_int_equal(count_free(&chain, "+joint_3.z", NULL), 37);
    assert_int_equal(count_free(&chain, "joint_3.z", NULL), 1);
    chain.element[2].type = MUKCA_REVOLUTE;

    /* a joint that has the name of a parameter is that joint; a dot in a name is no harm */
    strcpy(chain.element[0].name, "x");
    strcpy(chain.element[1].name, "arm.joint");
    assert_int_equal(count_free(&chain, "x", NULL), 6);
    assert_int_equal(count_free(&chain, "x.x,arm.joint.y", NULL), 2);
    assert_int_equal(count_free(&chain, "arm.joint", NULL), 6);

    /* the tip alone is not pulled to nominal */
    assert_int_equal(mukca_parameters_select(&p, &chain, NULL, NULL), MUKCA_OK);
    for (int i = 0; i < p.n; i++) assert_int_equal(p.regularised[i], p.index[i] < 36);
    const mukca_selection hold = {.regularise_tip = true};
    assert_int_equal(mukca_parameters_select(&p, &chain, &hold, NULL), MUKCA_OK);
    for (int i = 0; i < p.n; i++) assert_int_equal(p.regularised[i], 1);

    double theta[42], x[42], back[42];
    mukca_chain_theta(theta, &chain);
    memcpy(back, theta, sizeof theta);
    mukca_parameters_pack(x, &p, theta);
    for (int i = 0; i < p.n; i++) x[i] += i;
    mukca_parameters_unpack(back, &p, x);
    for (int i = 0; i < p.n; i++) assert_close(back[p.index[i]], theta[p.index[i]] + i, 0);
}

/* Pose log of the arm `truth`, seen from `tracker` (a pose of the arm's base in it). */
static void track(mukca_dataset *data, const mukca_chain *chain, const double *truth,
                  const mukca_frame *tracker, int rows, bool oriented, double sigma,
                  mukca_random *random)
{
    mukca_geometry geometry;
    mukca_geometry_set(&geometry, chain, truth);
    assert_int_equal(mukca_dataset_create(data, rows, JOINTS, 0, 0, NULL), MUKCA_OK);
    data->position = malloc(3 * (size_t)rows * sizeof *data->position);
    assert_non_null(data->position);
    if (oriented) data->quaternion = malloc(4 * (size_t)rows * sizeof *data->quaternion);
    for (int i = 0; i < rows; i++) {
        mukca_frame T;
        for (int j = 0; j < JOINTS; j++)
            data->q[i * JOINTS + j] = 2.5 * (2 * mukca_random_uniform(random) - 1);
        mukca_fk_pose(&T, &geometry, data->q + i * JOINTS, NULL);
        mukca_frame_multiply(&T, tracker, &T);
        for (int a = 0; a < 3; a++)
            data->position[3 * i + a] = T.p[a] + sigma * mukca_random_normal(random);
        if (oriented) mukca_rotation_to_quaternion(data->quaternion + 4 * i, T.R);
    }
}

static double held_out(const mukca_fit *fit, const mukca_dataset *data)
{
    mukca_geometry geometry;
    double sum = 0;
    mukca_geometry_set(&geometry, &fit->chain, fit->theta);
    for (int i = 0; i < data->n_rows; i++) {
        double x[3], square = 0;
        mukca_fk_position(x, &geometry, data->q + i * JOINTS, NULL);
        for (int a = 0; a < 3; a++) square += pow(x[a] - data->position[3 * i + a], 2);
        sum += sqrt(square) / data->n_rows;
    }
    return sum;
}

static void test_poses(void **state)
{
    (void)state;
    mukca_random random;
    mukca_chain chain;
    mukca_random_seed(&random, 31);
    for (int trial = 0; trial < 6; trial++) {
        const bool oriented = trial % 2, away = trial >= 2;
        mukca_frame tracker = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
        mukca_dataset train, test;
        mukca_fit fit;
        double truth[MUKCA_MAX_FREE], turn[3];
        make_arm(&chain);
        mukca_chain_theta(truth, &chain);
        for (int i = 0; i < 42; i++) truth[i] += 2e-3 * mukca_random_normal(&random);
        if (away) {
            for (int a = 0; a < 3; a++) turn[a] = mukca_random_normal(&random);
            mukca_rotation_exp(tracker.R, turn);
            for (int a = 0; a < 3; a++) tracker.p[a] = 2 * mukca_random_normal(&random);
        }
        track(&train, &chain, truth, &tracker, 60, oriented, 0, &random);
        track(&test, &chain, truth, &tracker, 40, oriented, 0, &random);
        if (trial >= 4) chain.n_elements--; /* the target's offset is not in the model */
        const mukca_fit_options options = {
            .free_base = away, .free_tool = trial >= 4, .cost.lambda = 1e-9};
        assert_int_equal(mukca_fit_run(&fit, &chain, &train, &options, NULL), MUKCA_OK);
        assert_true(fit.converged);
        assert_int_equal(fit.chain.n_elements, 7 + away);
        if (away) assert_string_equal(fit.chain.element[0].name, MUKCA_BASE_FRAME);
        if (trial >= 4) assert_string_equal(fit.chain.element[7].name, MUKCA_TOOL_FRAME);
        /* 42 parameters: 2 per axis are not unique, positions do not show the tip's orientation */
        if (!away) assert_int_equal(fit.identification.rank, oriented ? 30 : 27);
        assert_close(held_out(&fit, &test), 0, 1e-6);
        mukca_fit_free(&fit);
        mukca_dataset_free(&train);
        mukca_dataset_free(&test);
    }
}

/* All solvers and gradients come to one minimum, and the verdict says so. */
static void test_solvers(void **state)
{
    (void)state;
    mukca_random random;
    mukca_chain chain;
    mukca_dataset data;
    const mukca_frame tracker = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    double truth[MUKCA_MAX_FREE], least = 0;
    make_arm(&chain);
    mukca_random_seed(&random, 32);
    mukca_chain_theta(truth, &chain);
    for (int i = 0; i < 42; i++) truth[i] += 5e-3 * mukca_random_normal(&random);
    track(&data, &chain, truth, &tracker, 50, false, 1e-4, &random);
    for (int s = 0; mukca_solver_table[s]; s++)
        for (int kind = 0; kind < 2; kind++) {
            mukca_fit fit;
            mukca_fit_options options = {
                .solver = mukca_solver_table[s],
                .cost.gradient = kind ? MUKCA_GRADIENT_ANALYTIC : MUKCA_GRADIENT_FD};
            assert_int_equal(mukca_fit_run(&fit, &chain, &data, &options, NULL), MUKCA_OK);
            assert_true(fit.converged);
            assert_true(fit.outcome.evaluations < 100);
            assert_true(fit.calibrated.total < 0.01 * fit.nominal.total);
            if (least > 0) assert_close(fit.calibrated.total, least, 1e-9 * least);
            least = fit.calibrated.total;
            mukca_fit_free(&fit);
            /* one evaluation is not enough, and is not called converged */
            options.limits.max_evaluations = 2;
            assert_int_equal(mukca_fit_run(&fit, &chain, &data, &options, NULL), MUKCA_OK);
            assert_false(fit.converged);
            assert_int_equal(fit.outcome.stop, MUKCA_STOP_LIMIT);
            mukca_fit_free(&fit);
        }
    mukca_dataset_free(&data);
}

static bool stop_at_once(void *context)
{
    (void)context;
    return true;
}

/* What is not a number ends the run instead of hanging it; so does an interrupt. */
static void test_stops(void **state)
{
    (void)state;
    mukca_random random;
    mukca_chain chain;
    mukca_dataset data;
    mukca_parameters parameters;
    mukca_cost cost;
    double truth[MUKCA_MAX_FREE], x[MUKCA_MAX_FREE];
    const mukca_frame tracker = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    make_arm(&chain);
    mukca_random_seed(&random, 33);
    mukca_chain_theta(truth, &chain);
    track(&data, &chain, truth, &tracker, 20, false, 1e-4, &random);
    assert_int_equal(mukca_parameters_select(&parameters, &chain, NULL, NULL), MUKCA_OK);
    for (int s = 0; mukca_solver_table[s]; s++) {
        mukca_fit fit;
        mukca_solver_outcome outcome;
        mukca_fit_options options = {.solver = mukca_solver_table[s], .limits.stop = stop_at_once};
        assert_int_equal(mukca_fit_run(&fit, &chain, &data, &options, NULL), MUKCA_INTERRUPTED);
        mukca_pool pool = {0};
        assert_true(mukca_cost_setup(&cost, &pool, &chain, &parameters, &data, NULL));
        memcpy(x, cost.nominal, (size_t)parameters.n * sizeof *x);
        x[3] = NAN;
        assert_int_equal(mukca_solver_table[s]->run(x, &outcome, &cost, NULL, NULL), MUKCA_OK);
        assert_int_equal(outcome.stop, MUKCA_STOP_NOT_FINITE);
        mukca_pool_free(&pool);
    }
    mukca_dataset_free(&data);
}

/* The null space changes no residual; what is called identifiable is not in it. */
static void test_null_space(void **state)
{
    (void)state;
    mukca_random random;
    mukca_chain chain;
    mukca_dataset data;
    mukca_fit fit;
    double truth[MUKCA_MAX_FREE], moved[MUKCA_MAX_FREE];
    const mukca_frame tracker = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    make_arm(&chain);
    mukca_random_seed(&random, 34);
    mukca_chain_theta(truth, &chain);
    track(&data, &chain, truth, &tracker, 40, false, 1e-4, &random);
    assert_int_equal(mukca_fit_run(&fit, &chain, &data, NULL, NULL), MUKCA_OK);
    const int n = fit.parameters.n, hidden = n - fit.identification.rank;
    assert_int_equal(hidden, 15);
    mukca_geometry a, b;
    mukca_geometry_set(&a, &chain, fit.theta);
    for (int r = 0; r < hidden; r++) {
        double largest = 0;
        memcpy(moved, fit.theta, sizeof moved);
        for (int i = 0; i < n; i++) {
            const double weight = fit.null_space[r * n + i];
            moved[fit.parameters.index[i]] += 1e-6 * weight;
            largest = fmax(largest, fabs(weight));
            if (fit.identification.identifiable[i]) assert_true(fabs(weight) < 0.01);
        }
        assert_true(largest >= 1);
        mukca_geometry_set(&b, &chain, moved);
        for (int i = 0; i < data.n_rows; i++) {
            double p[3], q[3];
            mukca_fk_position(p, &a, data.q + i * JOINTS, NULL);
            mukca_fk_position(q, &b, data.q + i * JOINTS, NULL);
            for (int c = 0; c < 3; c++) assert_close(p[c], q[c], 1e-10);
        }
    }
    for (int i = 0; i < n; i++)
        assert_int_equal(isfinite(fit.identification.sigma[i]), fit.identification.identifiable[i]);
    mukca_fit_free(&fit);
    mukca_dataset_free(&data);
}

/* Standard errors over noise from a part of the samples are those of all of them. */
static void compare_precision(const mukca_chain *chain, const mukca_dataset *data, int most)
{
    mukca_parameters p;
    mukca_dataset samples;
    mukca_cost all, part, bounded;
    mukca_identification id[2];
    mukca_pool pool = {0};
    double work[MUKCA_IDENTIFY_WORK(MUKCA_MAX_FREE)];
    assert_int_equal(mukca_parameters_select(&p, chain, NULL, NULL), MUKCA_OK);
    assert_int_equal(mukca_part_take(&samples, data, most, NULL), MUKCA_OK);
    assert_true(samples.n_rows <= most && samples.n_rows > most / 3);
    assert_true(mukca_cost_setup(&all, &pool, chain, &p, data, NULL));
    assert_true(mukca_cost_setup(&part, &pool, chain, &p, &samples, NULL));
    assert_true(
        mukca_cost_setup(&bounded, &pool, chain, &p, data, &(mukca_cost_options){.part = &part}));
    assert_int_equal(mukca_identify(&id[0], NULL, &all, all.nominal, work, NULL), MUKCA_OK);
    assert_int_equal(mukca_identify(&id[1], NULL, &bounded, all.nominal, work, NULL), MUKCA_OK);
    assert_int_equal(id[0].rank, id[1].rank);
    assert_close(id[0].noise, id[1].noise, 1e-12 * id[0].noise);
    for (int i = 0; i < p.n; i++) {
        assert_int_equal(id[0].identifiable[i], id[1].identifiable[i]);
        if (id[0].identifiable[i])
            assert_close(id[1].sigma[i] / id[0].sigma[i], 1, 5 / sqrt(2.0 * most));
    }
    mukca_pool_free(&pool);
    mukca_dataset_free(&samples);
}

static void test_part(void **state)
{
    (void)state;
    enum { SOCKETS = 4, ROWS = 9000 };
    static const double share[SOCKETS] = {0.65, 0.95, 0.98, 1}; /* uneven, mixed; two placements */
    mukca_random random;
    mukca_chain chain;
    mukca_dataset data;
    double truth[MUKCA_MAX_FREE];
    const mukca_frame tracker = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    make_arm(&chain);
    mukca_random_seed(&random, 35);
    mukca_chain_theta(truth, &chain);
    track(&data, &chain, truth, &tracker, ROWS, true, 1e-4, &random);
    compare_precision(&chain, &data, ROWS / 3);
    mukca_dataset_free(&data);

    assert_int_equal(mukca_dataset_create(&data, ROWS, JOINTS, SOCKETS, 2, NULL), MUKCA_OK);
    for (int s = 0; s < SOCKETS; s++) data.sockets[s].placement = s / 2;
    for (int i = 0; i < ROWS; i++) {
        const double u = mukca_random_uniform(&random);
        while (u > share[data.socket[i] < 0 ? data.socket[i] = 0 : data.socket[i]])
            data.socket[i]++;
        for (int j = 0; j < JOINTS; j++)
            data.q[i * JOINTS + j] = 2.5 * (2 * mukca_random_uniform(&random) - 1);
    }
    data.n_distances = 2;
    data.distances = calloc(2, sizeof *data.distances);
    assert_non_null(data.distances);
    data.distances[0] = (mukca_distance){0, 1, 0.05};
    data.distances[1] = (mukca_distance){2, 3, 0.05};
    compare_precision(&chain, &data, ROWS / 3);
    mukca_dataset_free(&data);
}

/* The solver finds the minimum of all samples of a long recording, not that of the part. */
static void test_long(void **state)
{
    (void)state;
    mukca_random random;
    mukca_chain chain;
    mukca_dataset data;
    mukca_parameters p;
    mukca_cost cost;
    mukca_fit fit[2];
    mukca_pool pool = {0};
    double truth[MUKCA_MAX_FREE], x[2][MUKCA_MAX_FREE], g[MUKCA_MAX_FREE];
    const mukca_frame tracker = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    make_arm(&chain);
    mukca_random_seed(&random, 36);
    mukca_chain_theta(truth, &chain);
    for (int i = 0; i < 6 * chain.n_elements; i++) truth[i] += 1e-3 * mukca_random_normal(&random);
    track(&data, &chain, truth, &tracker, MUKCA_FIT_PART + 1000, false, 1e-4, &random);
    assert_int_equal(mukca_parameters_select(&p, &chain, NULL, NULL), MUKCA_OK);
    assert_true(mukca_cost_setup(&cost, &pool, &chain, &p, &data, NULL));
    for (int s = 0; s < 2; s++) { /* slsqp, lbfgs */
        const mukca_fit_options options = {.solver = mukca_solver_table[s]};
        assert_int_equal(mukca_fit_run(&fit[s], &chain, &data, &options, NULL), MUKCA_OK);
        assert_true(fit[s].converged && fit[s].n_part > 0 && fit[s].n_part <= MUKCA_FIT_PART);
        mukca_parameters_pack(x[s], &p, fit[s].theta);
        const double value = mukca_cost_evaluate(NULL, g, &cost, x[s]);
        mukca_cost_normal(cost.scratch, &cost, x[s], false);
        mukca_solver_factorise(cost.scratch, p.n);
        assert_true(mukca_solver_decrement(cost.scratch, g, x[s], p.n) <= 1e-8 * value);
        mukca_fit_free(&fit[s]);
    }
    mukca_pool_free(&pool);
    mukca_dataset_free(&data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_selection),  cmocka_unit_test(test_poses),
        cmocka_unit_test(test_solvers),    cmocka_unit_test(test_stops),
        cmocka_unit_test(test_null_space), cmocka_unit_test(test_part),
        cmocka_unit_test(test_long)};
    return cmocka_run_group_tests_name("fit", tests, NULL, NULL);
}
