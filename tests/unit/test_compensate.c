/* Corrected joint targets bring the true arm to 10,000 random targets, or say why not; along
 * paths they are smooth. */
#include "arm/compensate.h"
#include "close.h"
#include "gen3.h"
#include "math/random.h"

static mukca_corrected arm;
static mukca_geometry nominal;

/* The paper's offsets, compliance, and a gear ripple. */
FIXTURE(setup)
{
    double theta[6 * MUKCA_MAX_ELEMENTS];
    gen3_chain(&arm.chain);
    for (int k = 0; k < 7; k++)
        arm.chain.mass[arm.chain.n_masses++] = (mukca_mass){k, 1.2, {0, -0.02, -0.06}, {0}};
    mukca_chain_theta(theta, &arm.chain);
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < 3; i++) {
            theta[6 * k + i] += gen3_dp[k][i];
            if (k < 7) theta[6 * k + 3 + i] += i == 1 ? gen3_dq[k] : 0;
        }
    mukca_geometry_set(&arm.geometry, &arm.chain, theta);
    mukca_geometry_set(&nominal, &arm.chain, NULL);
    const mukca_effect effects[] = {make_effect(MUKCA_EFFECT_JOINT_COMPLIANCE, 1, 2e-4),
                                    make_effect(MUKCA_EFFECT_BASE_COMPLIANCE, -1, 5e-5),
                                    make_effect(MUKCA_EFFECT_BACKLASH, 3, 1e-3),
                                    make_effect(MUKCA_EFFECT_GEAR_HARMONIC, 3, 2e-4),
                                    make_effect(MUKCA_EFFECT_APPROACH_HYSTERESIS, 5, 5e-4)};
    arm.n_effects = (int)(sizeof effects / sizeof *effects);
    memcpy(arm.effects, effects, sizeof effects);
    arm.effects[2].variant.torque_scale = 1;
    arm.effects[3].variant.order = 160;
    arm.effects[3].terms = 2;
    arm.effects[3].coefficient[1] = 1e-4;
    return 0;
}

static void random_angles(double *q, mukca_random *random)
{
    for (int j = 0; j < 7; j++) {
        const mukca_element *e = &arm.chain.element[j];
        const double low = fmax(e->lower, -3), high = fmin(e->upper, 3);
        q[j] = low + (high - low) * mukca_random_uniform(random);
    }
}

TEST(random_targets_are_reached)
{
    mukca_compensator c;
    mukca_random random = mukca_random_seeded(21);
    double sent[7] = {0};
    int missed = 0;
    mukca_compensator_start(&c, &arm, false);
    for (int i = 0; i < 10000; i++) {
        double meant[7], q[7], move[7];
        mukca_frame target, reached, raw;
        random_angles(meant, &random);
        memcpy(q, meant, sizeof q);
        mukca_fk_pose(&target, &nominal, meant, NULL);
        for (int j = 0; j < 7; j++) move[j] = i > 0 ? meant[j] - sent[j] : 0;
        const mukca_joint_state uncorrected = {.placement = -1, .move = move};
        mukca_corrected_pose(&raw, &arm, meant, &uncorrected);
        mukca_compensation found = mukca_compensate_joints(q, &c, NULL);
        for (int j = 0; j < 7; j++) move[j] = i > 0 ? q[j] - sent[j] : 0;
        mukca_corrected_pose(&reached, &arm, q, &uncorrected); /* with the move as it was made */
        const double before = mukca_distance3(raw.p, target.p),
                     after = mukca_distance3(reached.p, target.p);
        assert_close(found.position_before, before, 1e-12);
        assert_close(found.position_error, after, 1e-12);
        if (!(after <= 0.01 * before)) assert_true(found.reach != MUKCA_REACH_OK);
        for (int j = 0; j < 7; j++)
            assert_true(q[j] >= arm.chain.element[j].lower && q[j] <= arm.chain.element[j].upper);
        missed += found.reach == MUKCA_REACH_LIMIT || found.reach == MUKCA_REACH_UNREACHED;
        memcpy(sent, q, sizeof sent);
    }
    assert_in_range(missed, 0, 399); /* out of reach of an arm with such offsets */
}

/* Along a smooth path the corrections are smooth, also through the joints' zeros. */
TEST(paths_are_continuous)
{
    mukca_compensator c;
    mukca_corrected smooth = arm;
    smooth.n_effects = 2;
    mukca_compensator_start(&c, &smooth, false);
    double last[7] = {0}, worst = 0;
    for (int i = 0; i <= 1000; i++) {
        double q[7], meant[7];
        for (int j = 0; j < 7; j++)
            meant[j] = 0.5 * sin(0.002 * i * (j + 1) + 1.3 * j) + (j % 2 ? 1.2 : 0.3);
        memcpy(q, meant, sizeof q);
        mukca_compensation found = mukca_compensate_joints(q, &c, NULL);
        assert_int_equal(found.reach, MUKCA_REACH_OK);
        for (int j = 0; j < 7; j++) {
            if (i > 0) worst = fmax(worst, fabs(q[j] - meant[j] - last[j]));
            last[j] = q[j] - meant[j];
        }
    }
    assert_true(worst < 2e-3);
}

TEST(limits_and_reach_are_told)
{
    mukca_compensator c;
    /* Stretched out upwards, with a true arm that is shorter. */
    mukca_corrected shorter = arm;
    shorter.n_effects = 0;
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < 3; i++)
            shorter.geometry.origin[k].p[i] = 0.99 * arm.chain.element[k].xyz[i];
    double up[7] = {0};
    mukca_compensator_start(&c, &shorter, true);
    mukca_compensation found = mukca_compensate_joints(up, &c, NULL);
    assert_int_equal(found.reach, MUKCA_REACH_UNREACHED);
    assert_true(found.position_error > 1e-3);
    /* Joints that stand at their limits and would have to go on. */
    mukca_corrected narrow = arm;
    double q[7] = {0.3, 0.4, 0.2, 1.0, 0.5, -0.7, 0.1};
    for (int j = 0; j < 7; j++)
        narrow.chain.element[j].lower = q[j], narrow.chain.element[j].upper = q[j] + 1e-4;
    mukca_compensator_start(&c, &narrow, false);
    found = mukca_compensate_joints(q, &c, NULL);
    assert_int_equal(found.reach, MUKCA_REACH_LIMIT);
}

TEST_MAIN(setup, NULL)
