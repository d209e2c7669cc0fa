/* Motions: an effect that was put into the torques is found where it is, as large as it is; a clean
 * arm is not accused; bad runs are refused with a reason. */
#include "arms.h"
#include "close.h"
#include "dynamics/inverse_dynamics.h"
#include "math/random.h"
#include "motion/items.h"

enum { N = 3, ROWS = 3200, RATE = 100 };

/* What is put into the torques. */
typedef struct {
    double payload, coulomb, viscous, delay, gain, wave; /* at joint 2 but payload, delay */
    double coupled; /* of a motor that turns with joints 1 and 2 */
    double unknown; /* Coulomb friction of joint 1 that the model lacks */
    double sign, speed;
    bool one_way;
} put;

static mukca_chain chain;
static double memory[2][ROWS * (2 * N + 1)];
static mukca_run run[2];
static mukca_motion motion;
static const char *without; /* an effect that the catalogue lacks; NULL: none */

FIXTURE(setup)
{
    static const double origin[N][6] = {
        {0, 0, 0.2, 0, 0, 0}, {0, 0, 0.1, -1.5708, 0, 0}, {0.4, 0, 0, 0, 0, 0}};
    make_chain(&chain, "RRR", origin, "j", 3);
    chain.gravity[2] = -9.80665;
    chain.n_masses = N;
    for (int k = 0; k < N; k++)
        chain.mass[k] = (mukca_mass){k, 4 - k, {0.15, 0.02, 0.03}, {0.02, 0.03, 0.03, 0, 0, 0}};
    return 0;
}

static void move(double q[N], double dq[N], double ddq[N], double t, const put *p)
{
    const double speed = p->speed > 0 ? p->speed : 1;
    for (int j = 0; j < N; j++) {
        q[j] = dq[j] = ddq[j] = 0;
        for (int k = 1; k <= 3; k++) {
            const double w = speed * k * (0.7 + 0.23 * j), a = 0.5 / k, f = w * t + j + k;
            q[j] += a * sin(f), dq[j] += a * w * cos(f), ddq[j] -= a * w * w * sin(f);
        }
        if (!p->one_way) continue;
        q[j] += 2.5 * t, dq[j] += 2.5;
    }
}

/* A run with noise of 5 mN m. */
static void record(int i, mukca_run_role role, int seed, const put *p)
{
    mukca_dynamics arm;
    mukca_random random = mukca_random_seeded((uint64_t)seed);
    double inertial[N * MUKCA_INERTIAL];
    const double com[3] = {0.1, 0, 0};
    mukca_dynamics_set(&arm, &chain);
    mukca_dynamics_inertials(inertial, &chain);
    mukca_inertial_add(inertial + (N - 1) * MUKCA_INERTIAL, p->payload, com, NULL);
    run[i] = (mukca_run){.name = "run.tsv",
                         .role = role,
                         .n = ROWS,
                         .time = memory[i],
                         .q = memory[i] + ROWS,
                         .effort = memory[i] + ROWS * (N + 1)};
    for (int r = 0; r < ROWS; r++) {
        double q[N], dq[N], ddq[N], torque[N];
        const double t = (double)r / RATE;
        move(q, dq, ddq, t - p->delay, p);
        mukca_dynamics_torque(torque, &arm, inertial, q, dq, ddq);
        torque[0] += p->unknown * tanh(dq[0] / MUKCA_SIGN_VELOCITY);
        torque[1] += p->coulomb * tanh(dq[1] / MUKCA_SIGN_VELOCITY) + p->viscous * dq[1] +
                     p->wave * sin(8 * q[1]);
        for (int j = 0; j < 2; j++)
            torque[j] += p->coupled * tanh((dq[0] + dq[1]) / MUKCA_SIGN_VELOCITY);
        torque[1] *= 1 + p->gain;
        move(run[i].q + r * N, dq, ddq, t, p);
        run[i].time[r] = t;
        for (int j = 0; j < N; j++)
            run[i].effort[r * N + j] =
                (p->sign < 0 ? -1 : 1) * (torque[j] + 0.005 * mukca_random_normal(&random));
    }
}

static mukca_status analyse(int n)
{
    mukca_motion_input input = {.chain = &chain, .run = run, .n_runs = n, .notes = {note, NULL}};
    if (without) input.disabled[mukca_torque_effect_find(without)] = true;
    return mukca_motion_analyse(&motion, &input, &error);
}

static void expect_one(const char *effect, int joint, double value, double most)
{
    const mukca_motion_finding *f = &motion.finding[0];
    assert_int_equal(motion.n_findings, 1);
    assert_int_equal(motion.verdict, MUKCA_MOTION_NAMED);
    assert_true(f->group.kind <= MUKCA_GROUP_EFFECT);
    assert_int_equal(f->group.effect, mukca_torque_effect_find(effect));
    assert_int_equal(f->group.apart, joint < 0);
    if (joint >= 0) assert_int_equal(f->group.from, joint);
    if (joint >= 0) assert_int_equal(f->group.to, joint);
    assert_close(f->coefficient.value, value, most);
    /* the interval of 95 %, widened to one of 99.99 % */
    assert_close(f->coefficient.value, value, f->coefficient.high - f->coefficient.low);
    assert_true(f->before_nm > f->after_nm);
}

TEST(test_a_clean_arm_is_not_accused)
{
    for (int seed = 1; seed <= 3; seed++) {
        record(0, MUKCA_RUN_NEW, seed, &(put){.speed = seed == 3 ? 0.3 : 1});
        assert_ok(analyse(1));
        assert_int_equal(motion.n_findings, 0);
        assert_int_equal(motion.verdict, MUKCA_MOTION_NONE);
        for (int j = 0; j < N; j++) assert_true(motion.joint[j].explained_nm <= 0.01);
    }
}

TEST(test_effects_are_found_with_their_sizes)
{
    static const struct {
        const char *effect;
        int joint;
        double value, most;
        put put;
    } cases[] = {{"viscous", 1, 0.8, 0.05, {.viscous = 0.8}},
                 {"coulomb", 1, 0.7, 0.05, {.coulomb = 0.7}},
                 {"payload", N - 1, 1.5, 0.3, {.payload = 1.5}},
                 {"torque_gain", 1, 0.12, 0.06, {.gain = 0.12}},
                 {"delay", -1, 0.012, 0.001, {.delay = 0.012}},
                 {"cogging", 1, 0.5, 0.05, {.wave = 0.5}}};
    for (int i = 0; i < 6; i++) {
        record(0, MUKCA_RUN_NEW, 5 + i, &cases[i].put);
        assert_ok(analyse(1));
        expect_one(cases[i].effect, cases[i].joint, cases[i].value, cases[i].most);
        assert_close(motion.shift_s, cases[i].put.delay, 0.001);
    }
    assert_in_range(8, motion.finding[0].order[0], motion.finding[0].order[1]);
}

TEST(test_what_the_catalogue_lacks_is_unknown)
{
    record(0, MUKCA_RUN_NEW, 5, &(put){.viscous = 0.8});
    without = "viscous";
    assert_ok(analyse(1));
    without = NULL;
    assert_true(motion.n_findings >= 1);
    assert_int_equal(motion.finding[0].group.family, MUKCA_TORQUE_VELOCITY);
    assert_int_equal(motion.finding[0].group.effect, -1);
    assert_int_equal(motion.finding[0].group.from, 1);
    assert_int_equal(motion.finding[0].group.to, 1);
    assert_int_equal(motion.verdict, MUKCA_MOTION_UNKNOWN);
}

/* In 10 s, of friction that the model lacks; the friction of a coupled wrist is not the joints'. */
TEST(test_friction_is_found_beside_that_of_a_coupled_wrist)
{
    double value = 0;
    bool coupled = false;
    record(0, MUKCA_RUN_NEW, 19, &(put){.coulomb = 0.7, .unknown = 1, .coupled = 0.8});
    run[0].n = 1000;
    assert_ok(analyse(1));
    for (int i = 0; i < motion.n_findings; i++) {
        const mukca_motion_finding *f = &motion.finding[i];
        coupled |= f->outside > 0.5 && f->group.family == MUKCA_TORQUE_VELOCITY;
        for (int k = 0; k < f->n_alternatives; k++)
            if (f->alternative[k].effect == MUKCA_MOTION_COULOMB && f->alternative[k].from == 1)
                value = f->alternative[k].amplitude.value;
    }
    assert_true(coupled);
    assert_close(value, 0.7, 0.1);
}

TEST(test_against_a_reference_only_changes_count)
{
    const put before = {.unknown = 1}, after = {.unknown = 1, .payload = 1.5};
    record(0, MUKCA_RUN_REFERENCE, 11, &before);
    record(1, MUKCA_RUN_NEW, 12, &before);
    assert_ok(analyse(2));
    assert_int_equal(motion.n_findings, 0);
    record(1, MUKCA_RUN_NEW, 12, &after);
    assert_ok(analyse(2));
    expect_one("payload", N - 1, 1.5, 0.3);
}

TEST(test_test_runs_are_not_fitted)
{
    record(0, MUKCA_RUN_NEW, 13, &(put){.viscous = 0.8});
    record(1, MUKCA_RUN_TEST, 14, &(put){0});
    assert_ok(analyse(2));
    assert_int_equal(motion.n_findings, 1);
    assert_int_equal(motion.finding[0].group.effect, MUKCA_MOTION_VISCOUS);
    /* these lack what the others have */
    assert_true(motion.joint[1].explained_nm > 10 * motion.joint[1].floor_nm);
}

TEST(test_bad_runs_are_refused)
{
    record(0, MUKCA_RUN_NEW, 15, &(put){.sign = -1});
    assert_refused(analyse(1), "opposite sign");
    record(0, MUKCA_RUN_NEW, 16, &(put){.speed = 1e-3});
    assert_error(analyse(1), MUKCA_UNIDENTIFIABLE, error, "no joint moves");
    record(0, MUKCA_RUN_NEW, 17, &(put){.one_way = true});
    assert_error(analyse(1), MUKCA_UNIDENTIFIABLE, error, "one direction only");
    record(0, MUKCA_RUN_NEW, 18, &(put){0});
    run[0].n = 400;
    assert_error(analyse(1), MUKCA_UNIDENTIFIABLE, error, "record");
    run[0].n = ROWS;
    for (int i = 0; i < ROWS; i++) run[0].time[i] *= 20;
    assert_error(analyse(1), MUKCA_UNIDENTIFIABLE, error, "samples per second");
}

/* Every named effect has columns, a unit, and sizes in it. */
TEST(test_the_table_is_complete)
{
    for (int e = 0; e < MUKCA_TORQUE_ROWS; e++) {
        const mukca_torque_effect *row = &mukca_torque_table[e];
        assert_int_equal(row->name != NULL, e < MUKCA_MOTION_EFFECTS);
        assert_non_null(row->unit);
        assert_true(row->size[0] > 0 && row->odds > 0 && row->variants > 0);
        assert_true(row->n * row->variants <= MUKCA_MOST_TERMS);
        if (row->name) assert_int_equal(mukca_torque_effect_find(row->name), e);
    }
    assert_int_equal(mukca_torque_effect_find("wind"), -1);
}

TEST_MAIN(setup, NULL)
