/* Planned poses: in their sockets, allowed, different from each other, and worth more than random
 * ones. */
#include "close.h"
#include "io/urdf.h"
#include "plan/choose.h"
#include "simulate/simulate.h"

static mukca_chain chain;
static mukca_geometry nominal;

FIXTURE(load)
{
    if (mukca_urdf_load(&chain, "data/demo/arm.urdf", NULL, &error)) return 1;
    mukca_geometry_set(&nominal, &chain, NULL);
    return 0;
}

static const mukca_plan_socket two_sockets[2] = {
    {.placement = "front", .label = "0", .centre = {0.45, -0.025, 0.05}},
    {.placement = "front", .label = "1", .centre = {0.45, 0.025, 0.05}}};

static mukca_status propose(mukca_plan *plan, const mukca_dataset *data,
                            const mukca_plan_socket *sockets, int n_sockets,
                            const mukca_plan_options *options)
{
    const mukca_plan_task task = {
        .chain = &chain, .data = data, .sockets = sockets, .n_sockets = n_sockets};
    return mukca_plan_run(plan, &task, options, &error);
}

TEST(test_rules)
{
    const mukca_plan_options options = {.rows = 20, .seed = 3, .tilt = 0.7};
    mukca_plan plan, again;
    assert_ok(propose(&plan, NULL, two_sockets, 2, &options));
    assert_int_equal(plan.n_rows, 20);
    assert_int_equal(plan.n_recorded, 0);
    int count[2] = {0};
    for (int i = 0; i < 20; i++) {
        const double *q = plan.rows[i].q;
        mukca_frame before[MUKCA_MAX_ELEMENTS], tip;
        mukca_fk_frames(before, &tip, &nominal, q, NULL);
        count[plan.rows[i].socket]++;
        double stem = 0, down = 0, off = 0;
        for (int a = 0; a < 3; a++) {
            const double d = tip.p[a] - before[6].p[a];
            off += pow(tip.p[a] - two_sockets[plan.rows[i].socket].centre[a], 2);
            stem += d * d;
            if (a == 2) down = -d;
        }
        assert_true(sqrt(off) <= 1e-8);
        assert_true(acos(down / sqrt(stem)) <= 0.7);
        for (int j = 0; j < 7; j++) {
            const mukca_element *e = &chain.element[chain.joint_element[j]];
            assert_true(q[j] >= e->lower + 0.02 && q[j] <= e->upper - 0.02);
            if (j > 1) assert_true(before[j].p[2] >= 0.05);
        }
        for (int k = 0; k < i; k++)
            assert_true(plan.rows[k].socket != plan.rows[i].socket ||
                        mukca_plan_differs(plan.rows[k].q, q, 7));
    }
    assert_int_equal(count[0], 10);
    /* the same seed, the same plan */
    assert_ok(propose(&again, NULL, two_sockets, 2, &options));
    for (int i = 0; i < 20; i++)
        assert_memory_equal(plan.rows[i].q, again.rows[i].q, 7 * sizeof(double));
    mukca_plan_free(&plan);
    mukca_plan_free(&again);
}

/* A session at one place, rows per socket. */
static void record(mukca_dataset *data, int rows, uint64_t seed)
{
    static mukca_corrected arm;
    double theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
    mukca_place place = {
        .name = "front", .placed = true, .pose = {{0, -1, 0, 1, 0, 0, 0, 0, 1}, {0.45, 0, 0.05}}};
    const mukca_simulate_options how = {
        .rows = rows, .distance = 0.05, .noise = 1e-4, .seed = seed};
    mukca_chain_theta(theta, &chain);
    mukca_simulate_arm(&arm, &chain, theta);
    assert_ok(mukca_simulate_sockets(
        data,
        &(mukca_simulated_session){.arm = &arm, .places = &place, .n_places = 1, .options = &how},
        &error));
}

TEST(test_better_than_random)
{
    const mukca_plan_options options = {.rows = 2 * 12, .seed = 1, .tilt = 4};
    int wins = 0;
    for (uint64_t seed = 1; seed <= 5; seed++) {
        mukca_dataset random;
        mukca_plan beside, alone;
        mukca_plan_socket sockets[2];
        int left_out;
        record(&random, 12, seed);
        assert_int_equal(mukca_plan_sockets(sockets, 1, &left_out, &nominal, &random), 1);
        assert_int_equal(left_out, 1);
        assert_int_equal(mukca_plan_sockets(sockets, 2, &left_out, &nominal, &random), 2);
        assert_int_equal(left_out, 0);
        mukca_plan_options more = options;
        more.rows = 4;
        assert_ok(propose(&beside, &random, sockets, 2, &more));
        assert_int_equal(beside.n_recorded, 24);
        assert_true(beside.expected_after < beside.expected_before);
        assert_ok(propose(&alone, NULL, sockets, 2, &options));
        assert_true(alone.expected_before > 1e-3);
        wins += alone.expected_after < beside.expected_before;
        mukca_plan_free(&beside);
        mukca_plan_free(&alone);
        mukca_dataset_free(&random);
    }
    assert_int_equal(wins, 5);
}

TEST_MAIN(load, NULL)
