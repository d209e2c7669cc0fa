/* Simulated recordings agree with their truth: effects, noise and faults have the size asked for.
 */
#include "diagnosed.h"
#include "mukca/gravity.h"

/* How far these angles put the ball from where it is recorded as seated in a row. */
static double miss(const double *q, int row)
{
    double ball[3], seat[3];
    const mukca_simulated_session session = {.arm = &s.arm, .places = s.places, .options = &s.how};
    const int socket = data.socket[row];
    mukca_simulate_seat(seat, &session, socket / 2, socket % 2, row % s.how.rows);
    mukca_fk_position(ball, &s.arm.geometry, q, NULL);
    return mukca_distance3(ball, seat);
}

/* True angles of a row under one effect on angles, written down again from its definition. */
static void turn(double *q, int row, mukca_effect_kind kind)
{
    const double *before = data.q + (row - 1) * data.n_joints, encoder = q[1];
    double move[MUKCA_MAX_JOINTS], largest = 0;
    mukca_gravity_load load;
    for (int j = 0; j < data.n_joints; j++) {
        move[j] = row ? q[j] - before[j] : 0;
        largest = fmax(largest, fabs(move[j]));
    }
    if (kind == MUKCA_EFFECT_JOINT_SCALE) q[1] *= 1.001;
    if (kind == MUKCA_EFFECT_JOINT_COUPLING) q[4] += 1e-3 * q[3];
    if (kind == MUKCA_EFFECT_ENCODER_ECCENTRICITY) q[2] += 3e-4 * sin(q[2]) - 4e-4 * cos(q[2]);
    if (kind == MUKCA_EFFECT_GEAR_HARMONIC) q[3] += 3e-4 * sin(160 * q[3]) + 4e-4 * cos(160 * q[3]);
    if (kind == MUKCA_EFFECT_APPROACH_HYSTERESIS) q[0] -= 0.5e-3 * tanh(move[0] / 0.02);
    for (int j = 0; j < data.n_joints && kind == MUKCA_EFFECT_READBACK_LAG && row; j++)
        q[j] += 1e-3 * move[j] / largest;
    if (kind == MUKCA_EFFECT_JOINT_DRIFT)
        q[5] += 2e-3 * (1 - exp(-(data.time[row] - data.time[0]) / 300));
    if (kind == MUKCA_EFFECT_ZERO_JUMP && data.socket[row] / 2 == 1) q[2] += 1e-3;
    for (int round = 0; round < 20 && kind == MUKCA_EFFECT_JOINT_COMPLIANCE; round++) {
        mukca_chain_moments(&load, &s.arm.chain, &s.arm.geometry, q, NULL, 0);
        q[1] = encoder - 3e-5 * load.torque[1]; /* under the load of the arm as it then stands */
    }
}

/* Effects have the size, the sign and the joint that were asked for. */
TEST(test_sizes)
{
    static const char *const cases[] = {"joint_scale:joint_2=1e-3",
                                        "joint_coupling:joint_5@-1=1e-3",
                                        "encoder_eccentricity:joint_3=3e-4,-4e-4",
                                        "gear_harmonic:joint_4@160=3e-4,4e-4",
                                        "approach_hysteresis:joint_1=1e-3",
                                        "readback_lag=1e-3",
                                        "joint_drift:joint_6@300=2e-3",
                                        "zero_jump:joint_3/left=1e-3",
                                        "joint_compliance:joint_2=3e-5"};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        double unmoved = 0;
        set_scene(&s, cases[c], 12);
        s.how.rows = 10;
        record_again();
        for (int i = 0; i < data.n_rows; i++) {
            double q[MUKCA_MAX_JOINTS];
            memcpy(q, data.q + i * data.n_joints, (size_t)data.n_joints * sizeof *q);
            unmoved = fmax(unmoved, miss(q, i));
            turn(q, i, s.hidden.effects[0].kind);
            assert_close(miss(q, i), 0, 1e-9);
        }
        assert_true(unmoved > 1e-4);
    }
}

/* Noise has the size that was asked for, and leaves the limits alone. */
TEST(test_noise)
{
    double square = 0;
    set_scene(&s, NULL, 3);
    s.how.noise = 2e-4;
    s.how.rows = 200;
    record_again();
    for (int i = 0; i < data.n_rows; i++) {
        square += pow(miss(data.q + i * data.n_joints, i), 2) / (3 * data.n_rows);
        for (int j = 0; j < data.n_joints; j++) {
            const mukca_element *e = &s.chain.element[s.chain.joint_element[j]];
            const double q = data.q[i * data.n_joints + j];
            assert_true(q >= e->lower && q <= e->upper);
        }
    }
    assert_close(sqrt(square), 2e-4, 0.05 * 2e-4);
}

/* Faults of the recording do to the rows what they say. */
TEST(test_faults)
{
    mukca_dataset clean;
    set_scene(&s, NULL, 4);
    record(&clean, &s);
    set_scene(&s,
              "tool_motion:front/0@12=1e-3,tool_motion:left/1@creep=0,0,-2e-3,"
              "wrong_socket:right/0@5,outlier:high/1@30=3e-3,duplicate:front/1@2",
              4);
    assert_int_equal(s.hidden.n_faults, 5);
    record_again();
    for (int i = 0; i < data.n_rows; i++) {
        const int socket = data.socket[i], row = i % 30;
        double off = 0;
        if (socket == 0 && row >= 11) off = 1e-3;
        if (socket == 3) off = 2e-3 * row / 29;
        if (socket == 4 && row == 4) off = 0.05;
        if (socket == 7 && row == 29) off = 3e-3;
        assert_close(miss(data.q + i * data.n_joints, i), off, 1e-9);
    }
    const int n = data.n_joints;
    assert_memory_equal(data.q + 31 * n, data.q + 30 * n, (size_t)n * sizeof(double));
    assert_memory_equal(data.q, clean.q, (size_t)(11 * n) * sizeof(double));
    mukca_dataset_free(&clean);
}

/* Measured efforts are the true arm's; a stale reading lags what was commanded. */
TEST(test_columns)
{
    set_scene(&s, "readback_lag=1e-3", 6);
    for (int k = 0; k < s.chain.n_masses; k++) s.arm.chain.mass[k].kg *= 1.1;
    s.arm.effects[0] = s.hidden.effects[0];
    s.arm.n_effects = 1;
    s.how.effort = s.how.command = true;
    record_again();
    for (int i = 0; i < data.n_rows; i++) {
        const double *q = data.q + i * data.n_joints;
        double largest = 0;
        mukca_gravity_load load;
        mukca_chain_moments(&load, &s.arm.chain, &s.arm.geometry, q, NULL, 0);
        for (int j = 0; j < data.n_joints; j++) {
            assert_close(data.effort[i * data.n_joints + j], load.torque[j], 1e-12);
            largest = fmax(largest, fabs(data.command[i * data.n_joints + j] - q[j]));
        }
        assert_close(largest, i ? 1e-3 : 0, 1e-12);
    }
}

TEST(test_grammar)
{
    set_scene(&s, NULL, 1);
    const bad_text wrong[] = {
        {"joint_complience:joint_1=1e-5", "did you mean joint_compliance"},
        {"joint_compliance=1e-5", "needs a joint"},
        {"joint_compliance:joint1=1e-5", "the first one is 'joint_1'"},
        {"joint_compliance:joint_1", "needs =VALUE in rad/(N*m)"},
        {"joint_compliance:joint_1=x", "a number must follow"},
        {"joint_compliance:joint_1=-1e-5", "cannot be negative"},
        {"joint_compliance:joint_1=1e-5,", "ends in a comma"},
        {"joint_compliance:joint_1=1e-5,2e-5", "needs 1 or 1 values"},
        {"joint_compliance:joint_1@2=1e-5", "expected no @"},
        {"base_compliance:joint_1=1e-5", "acts at no joint"},
        {"gear_harmonic:joint_1=1e-4", "expected @ORDER"},
        {"gear_harmonic:joint_1@401=1e-4", "expected @ORDER"},
        {"joint_coupling:joint_1@-1=1e-3", "a joint that exists"},
        {"axis_wobble:joint_1@3=1e-3", "expected @fixed1"},
        {"readback_lag@past=1", "expected @move, @command, or @READINGS"},
        {"zero_jump:joint_1=1e-3", "JOINT/PLACEMENT"},
        {"zero_jump:joint_1/back=1e-3", "no placement 'back'"},
        {"ball_shift:front=1,2", "needs 1 or 3 values"},
        {"tool_motion:front@3=1e-3", "PLACEMENT/SOCKET@ROW"},
        {"tool_motion:front/2@3=1e-3", "socket 0 or 1"},
        {"tool_motion:front/0@31=1e-3", "1 to 30"},
        {"tool_motion:front/0@3", "needs its size"},
        {"wrong_socket:front/0@creep", "1 to 30"},
        {"wrong_socket:front/0@3=1", "has no size"},
        {"duplicate:front/0@1", "2 to 30"},
        {"", "no effect is called ''"},
        {"a\n\033[2J", "no effect is called 'a??[2J'"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_error(cli_simulated_parse(&s.hidden, wrong[i].text, &error), MUKCA_USAGE, error,
                     wrong[i].part);
    set_scene(&s, "gear_harmonic:joint_4@240=3e-4,4e-4,encoder_eccentricity:joint_1=1e-3", 1);
    assert_int_equal(s.hidden.n_effects, 2);
    assert_int_equal(s.hidden.effects[0].variant.order, 240);
    assert_close(s.hidden.effects[0].coefficient[1], 4e-4, 0);
    const double *c = s.hidden.effects[1].coefficient;
    assert_close(hypot(c[0], c[1]), 1e-3, 1e-15);
}

TEST_MAIN(set_up, tear_down)
