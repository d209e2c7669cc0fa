/* The control law of tools/example_impedance.c: its spring against differences of the corrected
 * arm's pose, its limits, and no allocation.  tests/closed_loop has it move an arm. */
int example_main(int argc, char **argv);
#define main example_main
#include "../../tools/example_impedance.c"
#undef main

#include "close.h"
#include "gen3.h"
#include "noalloc.h"

static controller c;
static double q[7] = {0.3, -0.5, 0.2, 1.4, -0.4, 0.9, 0.1}, still[7];
static const double masses[7] = {1.4, 1.2, 1.2, 0.9, 0.7, 0.7, 0.4};

FIXTURE(setup)
{
    memset(&c, 0, sizeof c);
    mukca_chain *chain = &c.arm.chain;
    gen3_chain(chain);
    for (int k = 0; k < 7; k++)
        chain->mass[chain->n_masses++] = (mukca_mass){k, masses[k], {0.01, -0.02, -0.06}, {0}};
    mukca_geometry_set(&c.arm.geometry, chain, NULL);
    c.arm.n_effects = 1;
    c.arm.effects[0] = make_effect(MUKCA_EFFECT_JOINT_COMPLIANCE, 3, 1e-4);
    c.n = 7;
    for (int j = 0; j < 7; j++) c.torque_limit[j] = 100;
    mukca_row_state_stream(&c.recent, 7);
    control(&c, q, still, 0); /* the first state; no goal yet */
    for (int j = 0; j < 7; j++) assert_true(c.torque[j] == 0);
    return 0;
}

/* A goal with that offset from the posture q, reached at once; wanted posture q plus `lean`. */
static void give_goal(double x, double y, double z, double lean, bool compensate)
{
    goal_message goal = {.offset = {x, y, z}, .speed = 0.2, .compensate = compensate};
    memcpy(goal.taught, q, sizeof q);
    for (int j = 0; j < 7; j++) goal.posture[j] = q[j] + (j == 4 ? lean : 0);
    assert_true(set_goal(&c, &goal));
    c.share = 1;
}

/* Torques after 200 ms in one state: the limit of their rate then no longer acts. */
static void hold(const double *v)
{
    for (int i = 0; i < 200; i++) control(&c, q, v, 1e-3);
}

/* Jacobian of the corrected tip's position by central differences. */
static void differences(double J[3][7])
{
    for (int j = 0; j < 7; j++) {
        double at[7], high[3], low[3];
        memcpy(at, q, sizeof q);
        at[j] = q[j] + 1e-5;
        mukca_corrected_position(high, &c.arm, at, NULL);
        at[j] = q[j] - 1e-5;
        mukca_corrected_position(low, &c.arm, at, NULL);
        for (int i = 0; i < 3; i++) J[i][j] = (high[i] - low[i]) / 2e-5;
    }
}

TEST(test_spring)
{
    double J[3][7];
    differences(J);
    give_goal(0, 0, 0, 0, false);
    hold(still);
    for (int j = 0; j < 7; j++) assert_close(c.torque[j], 0, 1e-9);
    give_goal(1e-3, -2e-3, 3e-3, 0, false);
    hold(still);
    for (int j = 0; j < 7; j++) {
        const double expected = 15 * J[0][j] - 30 * J[1][j] + 6 * J[2][j];
        assert_close(c.torque[j], expected, 1e-3 * 30); /* the effect's part of the Jacobian */
    }
}

TEST(test_limits)
{
    double before[7];
    give_goal(0.02, 0.02, -0.05, 1, false);
    c.torque_limit[1] = 5;
    for (int i = 0; i < 300; i++) {
        memcpy(before, c.torque, sizeof before);
        control(&c, q, still, 1e-3);
        for (int j = 0; j < 7; j++)
            assert_true(fabs(c.torque[j] - before[j]) <= MAX_TORQUE_RATE + 1e-12);
    }
    for (int j = 0; j < 7; j++) assert_true(fabs(c.torque[j]) <= c.torque_limit[j] + 1e-12);
    assert_close(fabs(c.torque[1]), 5, 1e-9); /* reached: the others are scaled with it */
}

TEST(test_not_finite)
{
    const double v[7] = {(double)NAN};
    give_goal(0, 0, 0, 0, false);
    control(&c, q, v, 1e-3);
    assert_string_not_equal(c.limp, "");
    for (int j = 0; j < 7; j++) assert_true(c.torque[j] == 0);
}

TEST(test_no_allocation)
{
    const double v[7] = {0.01};
    give_goal(0.01, 0, 0, 0.1, true);
    const long before = calls;
    for (int i = 0; i < 20000; i++) control(&c, q, v, 1e-3);
    assert_true(calls == before);
    assert_string_equal(c.limp, "");
}

TEST_EACH(setup, NULL)
