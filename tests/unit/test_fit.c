/* Parameters are free as asked for, all solvers reach one minimum, poses are fitted in any frame,
 * and what the data cannot tell is called so. */
#include "arms.h"
#include "close.h"
#include "fit/evaluate.h"
#include "fit/fit.h"
#include "fit/solver.h"
#include "math/random.h"
#include "model/dataset_subset.h"

enum { JOINTS = 6 };

static mukca_chain chain;
static mukca_dataset data;
static mukca_random seeded;
static mukca_frame tracker;
static double truth[MUKCA_MAX_FREE];

/* A 6-axis arm (all axes z in their frames) with a fixed tip; a tracker in its base. */
FIXTURE(setup)
{
    static const double origin[7][6] = {{0, 0, 0.16, 0, 0, 0},      {0.05, 0, 0, M_PI_2, 0, 0},
                                        {-0.42, 0, 0, 0, 0, 0},     {-0.39, 0, 0.13, 0, 0, 0},
                                        {0, -0.1, 0, M_PI_2, 0, 0}, {0, 0.1, 0, -M_PI_2, 0, 0},
                                        {0.03, 0.04, 0.1, 0, 0, 0}};
    make_chain(&chain, "RRRRRRF", origin, "joint_", 0);
    tracker = (mukca_frame){{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    return 0;
}

FIXTURE(teardown)
{
    mukca_dataset_free(&data);
    return 0;
}

static int count_free(const char *list, const char *freeze)
{
    mukca_parameters p;
    const mukca_selection selection = {list, freeze, false};
    const mukca_status status = mukca_parameters_select(&p, &chain, &selection, &error);
    if (status != MUKCA_OK) {
        assert_int_equal(status, MUKCA_USAGE);
        assert_true(strlen(error.text) > 20);
        return -1;
    }
    for (int i = 1; i < p.n; i++) assert_true(p.index[i] > p.index[i - 1]);
    return p.n;
}

TEST(test_selection)
{
    mukca_parameters p;
    assert_int_equal(count_free(NULL, NULL), 42);
    assert_int_equal(count_free("joint_2", NULL), 6);
    assert_int_equal(count_free("joint_2.yaw,joint_2.x", NULL), 2);
    assert_int_equal(count_free("yaw", NULL), 7);
    assert_int_equal(count_free("yaw,joint_1", "joint_1.roll"), 11);
    assert_int_equal(count_free(NULL, "joint_7,x,y,z"), 18);
    assert_int_equal(count_free("joint_2.w", NULL), -1);
    assert_int_equal(count_free("joint_1,,x", NULL), -1);
    assert_int_equal(count_free("", NULL), -1);

    /* a fixed joint in between stays, unless it is asked for */
    chain.element[2].type = MUKCA_FIXED;
    assert_int_equal(count_free(NULL, NULL), 36);
    assert_int_equal(count_free("+joint_3.z", NULL), 37);
    assert_int_equal(count_free("joint_3.z", NULL), 1);
    chain.element[2].type = MUKCA_REVOLUTE;

    /* a joint that has the name of a parameter is that joint; a dot in a name is no harm */
    strcpy(chain.element[0].name, "x");
    strcpy(chain.element[1].name, "arm.joint");
    assert_int_equal(count_free("x", NULL), 6);
    assert_int_equal(count_free("x.x,arm.joint.y", NULL), 2);
    assert_int_equal(count_free("arm.joint", NULL), 6);

    /* the tip alone is not pulled to nominal */
    assert_ok(mukca_parameters_select(&p, &chain, &(mukca_selection){0}, NULL));
    for (int i = 0; i < p.n; i++) assert_int_equal(p.regularised[i], p.index[i] < 36);
    const mukca_selection hold = {.regularise_tip = true};
    assert_ok(mukca_parameters_select(&p, &chain, &hold, NULL));
    for (int i = 0; i < p.n; i++) assert_int_equal(p.regularised[i], 1);
}

/* An arm with errors of that size. */
static void perturb(double size)
{
    mukca_chain_theta(truth, &chain);
    for (int i = 0; i < 42; i++) truth[i] += size * mukca_random_normal(&seeded);
}

/* Pose log of the arm `truth`, seen from `tracker` (a pose of the arm's base in it). */
static void track(mukca_dataset *log, int rows, bool oriented, double sigma)
{
    mukca_geometry geometry;
    mukca_geometry_set(&geometry, &chain, truth);
    assert_ok(mukca_dataset_create(log, rows, JOINTS, 0, 0, NULL));
    log->position = zeroed(3 * (size_t)rows, sizeof *log->position);
    if (oriented) log->quaternion = zeroed(4 * (size_t)rows, sizeof *log->quaternion);
    for (int i = 0; i < rows; i++) {
        mukca_frame T;
        for (int j = 0; j < JOINTS; j++)
            log->q[i * JOINTS + j] = 2.5 * (2 * mukca_random_uniform(&seeded) - 1);
        mukca_fk_pose(&T, &geometry, log->q + i * JOINTS, NULL);
        mukca_frame_multiply(&T, &tracker, &T);
        for (int a = 0; a < 3; a++)
            log->position[3 * i + a] = T.p[a] + sigma * mukca_random_normal(&seeded);
        if (oriented) mukca_rotation_to_quaternion(log->quaternion + 4 * i, T.R);
    }
}

static double held_out(const mukca_fit *fit, const mukca_dataset *test)
{
    mukca_score score;
    const mukca_model model = {.chain = &fit->chain, .theta = fit->theta};
    assert_int_equal(mukca_evaluate(&score, NULL, &model, test), 1);
    return score.mae;
}

TEST(test_poses)
{
    seeded = mukca_random_seeded(31);
    for (int trial = 0; trial < 6; trial++) {
        const bool oriented = trial % 2, away = trial >= 2;
        mukca_dataset test;
        mukca_fit fit;
        double turn[3];
        setup(NULL);
        perturb(2e-3);
        if (away) {
            for (int a = 0; a < 3; a++) turn[a] = mukca_random_normal(&seeded);
            mukca_rotation_exp(tracker.R, turn);
            for (int a = 0; a < 3; a++) tracker.p[a] = 2 * mukca_random_normal(&seeded);
        }
        track(&data, 60, oriented, 0);
        track(&test, 40, oriented, 0);
        if (trial >= 4) chain.n_elements--; /* the target's offset is not in the model */
        const mukca_fit_options options = {
            .free_base = away, .free_tool = trial >= 4, .cost.lambda = 1e-9};
        assert_ok(mukca_fit_run(&fit, &chain, &data, &options, NULL));
        assert_true(fit.converged);
        assert_int_equal(fit.chain.n_elements, 7 + away);
        if (away) assert_string_equal(fit.chain.element[0].name, MUKCA_BASE_FRAME);
        if (trial >= 4) assert_string_equal(fit.chain.element[7].name, MUKCA_TOOL_FRAME);
        /* 42 parameters: 2 per axis are not unique, positions do not show the tip's orientation */
        if (!away) assert_int_equal(fit.identification.rank, oriented ? 30 : 27);
        assert_close(held_out(&fit, &test), 0, 1e-6);
        mukca_dataset_free(&data);
        mukca_dataset_free(&test);
    }
}

/* All solvers and gradients come to one minimum, and the verdict says so. */
TEST(test_solvers)
{
    double least = 0;
    seeded = mukca_random_seeded(32);
    perturb(5e-3);
    track(&data, 50, false, 1e-4);
    for (int s = 0; mukca_solver_table[s]; s++)
        for (int kind = 0; kind < 2; kind++) {
            mukca_fit fit;
            mukca_fit_options options = {
                .solver = mukca_solver_table[s],
                .cost.gradient = kind ? MUKCA_GRADIENT_ANALYTIC : MUKCA_GRADIENT_FD};
            assert_ok(mukca_fit_run(&fit, &chain, &data, &options, NULL));
            assert_true(fit.converged);
            assert_true(fit.outcome.evaluations < 100);
            assert_true(fit.calibrated.total < 0.01 * fit.nominal.total);
            if (least > 0) assert_close(fit.calibrated.total, least, 1e-9 * least);
            least = fit.calibrated.total;
            /* one evaluation is not enough, and is not called converged */
            options.limits.max_evaluations = 2;
            assert_ok(mukca_fit_run(&fit, &chain, &data, &options, NULL));
            assert_false(fit.converged);
            assert_int_equal(fit.outcome.stop, MUKCA_STOP_LIMIT);
        }
}

static bool stop_at_once(void *context)
{
    (void)context;
    return true;
}

/* What is not a number ends the run instead of hanging it; so does an interrupt. */
TEST(test_stops)
{
    mukca_parameters parameters;
    mukca_cost cost;
    double x[MUKCA_MAX_FREE];
    seeded = mukca_random_seeded(33);
    perturb(0);
    track(&data, 20, false, 1e-4);
    assert_ok(mukca_parameters_select(&parameters, &chain, &(mukca_selection){0}, NULL));
    for (int s = 0; mukca_solver_table[s]; s++) {
        mukca_fit fit;
        mukca_solver_outcome outcome;
        mukca_fit_options options = {.solver = mukca_solver_table[s], .limits.stop = stop_at_once};
        assert_int_equal(mukca_fit_run(&fit, &chain, &data, &options, NULL), MUKCA_INTERRUPTED);
        mukca_pool pool = {0};
        assert_true(
            mukca_cost_setup(&cost, &pool, &chain, &parameters, &data, &(mukca_cost_options){0}));
        memcpy(x, cost.nominal, (size_t)parameters.n * sizeof *x);
        x[3] = NAN;
        assert_ok(mukca_solver_table[s]->run(x, &outcome, &cost, mukca_solver_table[s],
                                             &(mukca_solver_options){0}, NULL));
        assert_int_equal(outcome.stop, MUKCA_STOP_NOT_FINITE);
        mukca_pool_free(&pool);
    }
}

/* Standard errors over noise from a part of the samples are those of all of them. */
static void compare_precision(int most)
{
    mukca_parameters p;
    mukca_dataset samples;
    mukca_cost all, part, bounded;
    mukca_identification id[2];
    mukca_pool pool = {0};
    assert_ok(mukca_parameters_select(&p, &chain, &(mukca_selection){0}, NULL));
    assert_ok(mukca_part_take(&samples, &data, most, NULL));
    assert_true(samples.n_rows <= most && samples.n_rows > most / 3);
    assert_true(mukca_cost_setup(&all, &pool, &chain, &p, &data, &(mukca_cost_options){0}));
    assert_true(mukca_cost_setup(&part, &pool, &chain, &p, &samples, &(mukca_cost_options){0}));
    assert_true(
        mukca_cost_setup(&bounded, &pool, &chain, &p, &data, &(mukca_cost_options){.part = &part}));
    assert_ok(mukca_identify(&id[0], &all, all.nominal, &pool, NULL));
    assert_ok(mukca_identify(&id[1], &bounded, all.nominal, &pool, NULL));
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

TEST(test_part)
{
    enum { SOCKETS = 4, ROWS = 9000 };
    static const double share[SOCKETS] = {0.65, 0.95, 0.98, 1}; /* uneven, mixed; two placements */
    seeded = mukca_random_seeded(35);
    perturb(0);
    track(&data, ROWS, true, 1e-4);
    compare_precision(ROWS / 3);
    mukca_dataset_free(&data);

    assert_ok(mukca_dataset_create(&data, ROWS, JOINTS, SOCKETS, 2, NULL));
    for (int s = 0; s < SOCKETS; s++) data.sockets[s].placement = s / 2;
    for (int i = 0; i < ROWS; i++) {
        const double u = mukca_random_uniform(&seeded);
        while (u > share[data.socket[i] < 0 ? data.socket[i] = 0 : data.socket[i]])
            data.socket[i]++;
        for (int j = 0; j < JOINTS; j++)
            data.q[i * JOINTS + j] = 2.5 * (2 * mukca_random_uniform(&seeded) - 1);
    }
    data.n_distances = 2;
    data.distances = zeroed(2, sizeof *data.distances);
    data.distances[0] = (mukca_distance){.a = 0, .b = 1, .distance = 0.05};
    data.distances[1] = (mukca_distance){.a = 2, .b = 3, .distance = 0.05};
    compare_precision(ROWS / 3);
}

/* The solver finds the minimum of all samples of a long recording, not that of the part. */
TEST(test_long)
{
    mukca_parameters p;
    mukca_cost cost;
    mukca_fit fit[2];
    mukca_pool pool = {0};
    double x[2][MUKCA_MAX_FREE], g[MUKCA_MAX_FREE];
    seeded = mukca_random_seeded(36);
    perturb(1e-3);
    track(&data, MUKCA_MOST_SAMPLES + 1000, false, 1e-4);
    assert_ok(mukca_parameters_select(&p, &chain, &(mukca_selection){0}, NULL));
    assert_true(mukca_cost_setup(&cost, &pool, &chain, &p, &data, &(mukca_cost_options){0}));
    for (int s = 0; s < 2; s++) { /* slsqp, lbfgs */
        const mukca_fit_options options = {.solver = mukca_solver_table[s]};
        assert_ok(mukca_fit_run(&fit[s], &chain, &data, &options, NULL));
        assert_true(fit[s].converged && fit[s].n_part > 0 && fit[s].n_part <= MUKCA_MOST_SAMPLES);
        mukca_parameters_pack(x[s], &p, fit[s].theta);
        const double value = mukca_cost_evaluate(NULL, g, &cost, x[s]);
        mukca_cost_normal(cost.matrix[0], &cost, x[s], false);
        mukca_solver_factorise(cost.matrix[0], p.n);
        assert_true(mukca_solver_decrement(cost.matrix[0], g, x[s], p.n) <= 1e-8 * value);
    }
    mukca_pool_free(&pool);
}

TEST_EACH(setup, teardown)
