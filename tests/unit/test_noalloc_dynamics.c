/* Torques of moving arms: against Pinocchio and MuJoCo, regressor against recursion, gravity
 * against the static load; without allocation. */
#include "arms.h"
#include "close.h"
#include "dynamics/inverse_dynamics.h"
#include "dynamics/signals.h"
#include "io/urdf.h"
#include "math/random.h"
#include "mukca/gravity.h"
#include "noalloc.h"

enum { N = 4, P = N * MUKCA_INERTIAL }; /* joints of torques.urdf */

static mukca_chain chain;
static mukca_dynamics dynamics;
static double p[P], q[N], dq[N], ddq[N];
static mukca_random generator;

FIXTURE(load)
{
    const mukca_urdf_options options = {.tip = "ball"};
    if (mukca_urdf_load(&chain, "tests/unit/torques.urdf", &options, &error)) return 1;
    mukca_dynamics_set(&dynamics, &chain);
    mukca_dynamics_inertials(p, &chain);
    generator = mukca_random_seeded(5);
    return 0;
}

static void draw_motion(void)
{
    for (int j = 0; j < N; j++) {
        q[j] = 4 * mukca_random_uniform(&generator) - 2;
        dq[j] = 2 * mukca_random_normal(&generator);
        ddq[j] = 5 * mukca_random_normal(&generator);
    }
}

/* Torques of Pinocchio 4.1.0, equal to MuJoCo 4.0.0's to 1e-12: tools/interop/dynamics.py
 * --reference */
static const double reference[3][4][N] = {
    {{0.751, 0.397, 1.654, -1.099},
     {0.158, -1.396, -0.044, 1.043},
     {0.784, -0.935, -12.584, -2.693},
     {-17.8243822793, -47.7535262083289, 1.83417512001194, 0.278337500510646}},
    {{-1.199, 0.374, -2.968, 1.285},
     {-2.016, -0.686, -2.852, -1.934},
     {-0.243, 0.567, -7.651, -2.389},
     {7.97941846867779, 33.9613989729883, -1.22027567056251, 0.15792878008181}},
    {{1.782, -0.032, -1.182, -0.886},
     {-2.763, -0.353, -1.901, 0.407},
     {-4.893, -4.044, 5.304, -4.038},
     {-17.515910113432, -81.9938063577384, -1.92955507892448, -0.496373637333688}}};

TEST(torques_are_those_of_pinocchio_and_mujoco)
{
    for (int r = 0; r < 3; r++) {
        double torque[N];
        mukca_dynamics_torque(torque, &dynamics, p, reference[r][0], reference[r][1],
                              reference[r][2]);
        for (int j = 0; j < N; j++) assert_close(torque[j], reference[r][3][j], 1e-9);
    }
}

TEST(the_regressor_times_the_parameters_is_the_torque)
{
    for (int trial = 0; trial < 20; trial++) {
        double Y[N * P], torque[N];
        draw_motion();
        for (int i = 0; i < P; i++) p[i] = mukca_random_normal(&generator);
        mukca_dynamics_torque(torque, &dynamics, p, q, dq, ddq);
        mukca_dynamics_regressor(Y, &dynamics, q, dq, ddq);
        for (int j = 0; j < N; j++) {
            double sum = 0;
            for (int i = 0; i < P; i++) sum += Y[j * P + i] * p[i];
            for (int i = 0; i < j * MUKCA_INERTIAL; i++)
                assert_true(Y[j * P + i] == 0); /* links before the joint */
            assert_close(sum, torque[j], 1e-9);
        }
    }
}

TEST(at_rest_the_torque_is_the_static_load_also_of_a_tilted_base)
{
    mukca_geometry geometry;
    double theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
    const double rest[N] = {0};
    for (int k = 0; k < chain.n_elements; k++)
        for (int i = 0; i < 3; i++) {
            chain.element[k].xyz[i] += 0.05 * mukca_random_normal(&generator);
            chain.element[k].rpy[i] += 0.05 * mukca_random_normal(&generator);
        }
    mukca_chain_theta(theta, &chain);
    mukca_geometry_set(&geometry, &chain, theta);
    for (int trial = 0; trial < 5; trial++) {
        mukca_gravity_load load;
        double torque[N];
        draw_motion();
        for (int i = 0; i < 3; i++) chain.gravity[i] = 6 * mukca_random_normal(&generator);
        mukca_dynamics_set(&dynamics, &chain);
        mukca_dynamics_inertials(p, &chain);
        mukca_dynamics_torque(torque, &dynamics, p, q, rest, rest);
        mukca_chain_moments(&load, &chain, &geometry, q, NULL, 0);
        for (int j = 0; j < N; j++) assert_close(torque[j], load.torque[j], 1e-11);
    }
}

TEST(a_body_and_its_halves_have_the_same_parameters)
{
    const double com[3] = {0.1, -0.2, 0.3}, bar[6] = {0.02, 0.02, 0, 0, 0, 0}; /* 2 kg at 0.1 m */
    double one[MUKCA_INERTIAL] = {0}, two[MUKCA_INERTIAL] = {0};
    mukca_inertial_add(one, 2, com, bar);
    for (int end = -1; end < 2; end += 2)
        mukca_inertial_add(two, 1, (double[3]){0.1, -0.2, 0.3 + 0.1 * end}, NULL);
    for (int i = 0; i < MUKCA_INERTIAL; i++) assert_close(one[i], two[i], 1e-15);
}

TEST(nothing_is_allocated)
{
    static double Y[N * P], x[64 * 3], dx[64 * 3], scratch[64 + 2 * 64];
    mukca_lowpass lowpass;
    const long before = calls;
    mukca_dynamics_set(&dynamics, &chain);
    mukca_dynamics_inertials(p, &chain);
    mukca_dynamics_regressor(Y, &dynamics, q, dq, ddq);
    mukca_dynamics_torque(Y, &dynamics, p, q, dq, ddq);
    mukca_lowpass_set(&lowpass, 3, 10, 100);
    assert_true(mukca_lowpass_scratch(&lowpass, 64) <= sizeof scratch / sizeof *scratch);
    mukca_lowpass_apply(x, 64, 3, 3, &lowpass, scratch);
    mukca_differences(dx, x, 64, 3, 0.01);
    assert_int_equal(calls, before);
}

TEST_EACH(load, NULL)
