/* Simulated runs of a moving arm: each effect changes the torques as defined; path and
 * noise are those asked for; specifications are read or refused. */
#include "cli/simulate.h"
#include "close.h"
#include "dynamics/inverse_dynamics.h"
#include "io/urdf.h"

enum { N = 7, MOST = 4096 };

/* A recorded row. */
typedef struct {
    double t, q[N], effort[N];
} row;

static mukca_chain chain;
static cli_simulated hidden;
static mukca_simulated_motion motion;
static row plain[MOST], rows[MOST];
static int n_rows;

static void take(void *context, double time, const double *q, const double *effort)
{
    row *to = context;
    assert_true(n_rows < MOST);
    to[n_rows].t = time;
    memcpy(to[n_rows].q, q, sizeof to->q);
    memcpy(to[n_rows].effort, effort, sizeof to->effort);
    n_rows++;
}

/* Record with these effects (NULL: none). */
static void record(row *to, const char *effects)
{
    hidden = (cli_simulated){.chain = &chain, .moves = true};
    if (effects) assert_ok(cli_simulated_parse(&hidden, effects, &error));
    motion.effects = hidden.torques;
    motion.n_effects = hidden.n_torques;
    n_rows = 0;
    assert_ok(mukca_simulate_motion(&motion, take, to));
}

FIXTURE(set_up)
{
    motion = (mukca_simulated_motion){.chain = &chain, .runs = 1, .seconds = 8, .rate = 100};
    motion.speed = 1.5, motion.seed = 3;
    if (mukca_urdf_load(&chain, "data/demo/arm.urdf", NULL, &error)) return 1;
    record(plain, NULL);
    return 0;
}

/* Central differences of the path at a row; errors of some 1e-3 at 100 Hz. */
static double velocity(int r, int j)
{
    return (plain[r + 1].q[j] - plain[r - 1].q[j]) * motion.rate / 2;
}

static double acceleration(int r, int j)
{
    return (plain[r + 1].q[j] - 2 * plain[r].q[j] + plain[r - 1].q[j]) * motion.rate * motion.rate;
}

TEST(the_torque_is_that_of_the_rigid_body)
{
    mukca_dynamics dynamics;
    double p[N * MUKCA_INERTIAL];
    mukca_dynamics_set(&dynamics, &chain);
    mukca_dynamics_inertials(p, &chain);
    assert_int_equal(n_rows, 801);
    for (int r = 1; r < n_rows - 1; r++) {
        double dq[N], ddq[N], torque[N];
        for (int j = 0; j < N; j++) dq[j] = velocity(r, j), ddq[j] = acceleration(r, j);
        mukca_dynamics_torque(torque, &dynamics, p, plain[r].q, dq, ddq);
        for (int j = 0; j < N; j++) assert_close(plain[r].effort[j], torque[j], 0.05);
    }
}

TEST(the_path_keeps_its_limits_and_uses_them)
{
    double fastest[N] = {0};
    for (int r = 1; r < n_rows - 1; r++)
        for (int j = 0; j < N; j++) {
            const mukca_element *e = &chain.element[chain.joint_element[j]];
            assert_true(plain[r].q[j] > e->lower && plain[r].q[j] < e->upper);
            fastest[j] = fmax(fastest[j], fabs(velocity(r, j)));
        }
    for (int j = 0; j < N; j++) {
        assert_true(fastest[j] < 1.5 + 1e-3);
        assert_true(fastest[j] > 0.2); /* some joints meet their limits of travel first */
        assert_close(plain[1].q[j], plain[0].q[j], 1e-4); /* starts and ends at rest */
        assert_close(plain[800].q[j], plain[799].q[j], 1e-4);
    }
}

/* What an effect at joint_4 of size 2 adds there, given q, dq, ddq, the load and the time. */
static double wanted(int kind, const double v[5])
{
    const double sign = v[1] > 0 ? 1 : -1;
    const double all[] = {2 * v[2],
                          2 * sign,
                          2 * v[1],
                          2 * sign * exp(-v[1] * v[1] / 0.04),
                          2 * sign * fabs(v[3]),
                          2 * fabs(v[1]),
                          2,
                          2 * (v[0] - 0.5),
                          2 * sin(6 * v[0]) + cos(6 * v[0]),
                          2 * sign * exp(-v[4] / 5),
                          2 * v[3]};
    return all[kind];
}

TEST(effects_at_a_joint_add_their_torque_there_only)
{
    static const char *const text[] = {"armature:joint_4=2",      "coulomb:joint_4=2",
                                       "viscous:joint_4=2",       "stribeck:joint_4@0.2=2",
                                       "load_friction:joint_4=2", "asymmetry:joint_4=2",
                                       "offset:joint_4=2",        "spring:joint_4=2,0.5",
                                       "cogging:joint_4@6=2,1",   "thermal_friction:joint_4@5=2",
                                       "torque_gain:joint_4=2"};
    for (int kind = 0; kind < (int)(sizeof text / sizeof *text); kind++) {
        record(rows, text[kind]);
        for (int r = 1; r < n_rows - 1; r++) {
            const double dq = velocity(r, 3);
            const double v[5] = {plain[r].q[3], dq, acceleration(r, 3), plain[r].effort[3],
                                 plain[r].t};
            for (int j = 0; j < N; j++) {
                const double change = rows[r].effort[j] - plain[r].effort[j];
                if (j != 3)
                    assert_true(change == 0);
                else if (fabs(dq) > 0.01) /* the sign is certain */
                    assert_close(change, wanted(kind, v), 0.02);
            }
        }
    }
}

TEST(masses_change_the_torque_as_the_model_has_them)
{
    mukca_chain other = chain;
    record(rows,
           "payload=0.7,0.01,0.02,0.03,link_mass:joint_2=1.5,link_centre:joint_3=0.02,0,-0.01");
    static row changed[MOST];
    memcpy(changed, rows, sizeof rows);
    for (int m = 0; m < chain.n_masses; m++) {
        mukca_mass *mass = &chain.mass[m];
        if (mass->element == chain.joint_element[1]) {
            for (int i = 0; i < 6; i++) mass->inertia[i] *= 1 + 1.5 / mass->kg;
            mass->kg += 1.5;
        }
        if (mass->element == chain.joint_element[2]) mass->com[0] += 0.02, mass->com[2] -= 0.01;
    }
    chain.mass[chain.n_masses++] =
        (mukca_mass){.element = chain.n_elements - 1, .kg = 0.7, .com = {0.01, 0.02, 0.03}};
    record(rows, NULL);
    for (int r = 0; r < n_rows; r++)
        for (int j = 0; j < N; j++) assert_close(changed[r].effort[j], rows[r].effort[j], 1e-9);
    assert_true(fabs(changed[0].effort[1] - plain[0].effort[1]) > 0.1);
    chain = other;
}

TEST(a_delay_shifts_the_torques)
{
    record(rows, "delay=0.02,delay:joint_2=0.01");
    for (int r = 3; r < n_rows; r++)
        for (int j = 0; j < N; j++)
            assert_close(rows[r].effort[j], plain[r - (j == 1 ? 3 : 2)].effort[j], 1e-9);
}

TEST(noise_and_runs_are_as_asked)
{
    motion.noise = 0.02, motion.runs = 3;
    double low[N], high[N], squares[N] = {0};
    record(rows, NULL);
    assert_int_equal(n_rows, 3 * 801);
    for (int r = 0; r < 801; r++)
        for (int j = 0; j < N; j++) {
            const double e = plain[r].effort[j];
            low[j] = r ? fmin(low[j], e) : e, high[j] = r ? fmax(high[j], e) : e;
            squares[j] += pow(rows[r].effort[j] - e, 2);
        }
    for (int j = 0; j < N; j++) /* five standard errors */
        assert_close(sqrt(squares[j] / 801) / (0.01 * (high[j] - low[j])), 1, 5 / sqrt(2 * 801));
    assert_close(rows[801].t, rows[800].t + MUKCA_RUN_PAUSE, 1e-9);
    assert_true(fabs(rows[1200].q[0] - rows[400].q[0]) > 1e-3); /* another path */
    assert_int_equal(set_up(NULL), 0);
    record(rows, NULL);
    assert_memory_equal(rows, plain, sizeof *rows * (size_t)n_rows); /* the same seed */
}

TEST(specifications_are_read_or_refused)
{
    static const bad_text wrong[] = {
        {"joint_compliance:joint_1=1e-5", "no effect of a moving arm"},
        {"coulomb=1", "needs a joint"},
        {"coulomb:elbow=1", "the first one is 'joint_1'"},
        {"coulomb:joint_1", "needs 1 values"},
        {"coulomb:joint_1@3=1", "has no @"},
        {"cogging:joint_1=1", "@ needs its order, above 0"},
        {"cogging:joint_1@x=1", "@ needs its order"},
        {"stribeck:joint_1@-1=1", "@ needs its velocity, above 0, in rad/s"},
        {"payload:joint_1=1", "is at the tip"},
        {"payload=1,2", "needs 1 or more values, the first in kg"},
        {"link_centre:joint_1=1", "needs 3 values"},
        {"link_mass:joint_1=-100", "leaves the link no mass"},
        {"offset:joint_1=1e7", "larger than any arm's"},
    };
    hidden = (cli_simulated){.chain = &chain, .moves = true};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_error(cli_simulated_parse(&hidden, wrong[i].text, &error), MUKCA_USAGE, error,
                     wrong[i].part);
    chain.n_masses = 0;
    assert_error(cli_simulated_parse(&hidden, "link_mass:joint_1=1", &error), MUKCA_USAGE, error,
                 "no mass; give --inertials");
}

TEST_EACH(set_up, NULL)
