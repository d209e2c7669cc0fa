/* Acceptance by prediction: what a recording determines about the tip decides, repeated postures
 * count once, and the error that is announced is that of the true arm. */
#include "accept/accept.h"
#include "arms.h"
#include "scene.h"

static scene arm;
static mukca_dataset data;
static mukca_fit fit;
static mukca_offsets table;

FIXTURE(set_up)
{
    set_scene(&arm, NULL, 5);
    arm.how.noise = 1e-4;
    record(&data, &arm);
    return 0;
}

FIXTURE(tear_down)
{
    mukca_dataset_free(&data);
    return 0;
}

/* Calibrate and judge. */
static const mukca_acceptance *calibrate(void)
{
    const mukca_fit_options options = {0};
    assert_ok(mukca_fit_run(&fit, &arm.chain, &data, &options, &error));
    mukca_fit_offsets(&table, &fit);
    mukca_cross_validation held = {.held = NULL};
    assert_ok(mukca_fit_cross_validate(&held, &fit, &arm.chain, &data, &options, &error));
    assert_ok(mukca_accept_fit(&table, &fit, &held, &data, &options, &error));
    mukca_cross_validation_free(&held);
    return &table.acceptance;
}

static void refused_for(const char *reason)
{
    const mukca_acceptance *a = calibrate();
    if (a->accepted || !strstr(a->reason, reason))
        fail_msg("%s: %s", a->accepted ? "accepted" : a->reason, reason);
}

/* Mean distance of the true tip from that of theta (NULL: nominal), moved rigidly, in postures of
 * the data. */
static double true_error(const double *theta)
{
    enum { N = 200 };
    static double p[2][N][3];
    mukca_geometry geometry;
    mukca_geometry_set(&geometry, &arm.chain, theta);
    for (int i = 0; i < N; i++) {
        mukca_fk_position(p[0][i], &geometry, data.q + i * data.n_joints, NULL);
        mukca_fk_position(p[1][i], &arm.arm.geometry, data.q + i * data.n_joints, NULL);
    }
    return rigid_error(NULL, p[0], p[1], N);
}

TEST(the_announced_error_is_the_true_one)
{
    const mukca_acceptance *a = calibrate();
    if (!a->accepted) fail_msg("%s", a->reason);
    const double after = true_error(table.theta), before = true_error(NULL);
    assert_true(a->postures == data.n_rows);
    assert_string_equal(a->at_rest, "");
    assert_true(a->error_here_low_m < after && after < a->error_here_high_m);
    /* the distances of the tool are exact here: the scale of the arm is better than announced */
    assert_true(after < a->error_here_m);
    assert_true(before < 2 * a->error_before_here_m && a->error_before_here_m < 2 * before);
    assert_true(a->error_workspace_m < a->error_before_m);
}

/* All placements have the same artefact: their number does not reduce the error of its distance,
 * which scales the arm; a measured one has less, and the parts of several would. */
TEST(the_error_of_the_distance_is_common)
{
    const double as_printed = calibrate()->error_here_m,
                 part = table.acceptance.error_here_distance_m;
    double scaled[MUKCA_MAX_THETA];
    for (int i = 0; i < MUKCA_PARAMETERS * arm.chain.n_elements; i++)
        scaled[i] = table.theta[i] * (i % MUKCA_PARAMETERS < 3 ? 1.002 : 1);
    memcpy(table.theta, scaled, sizeof scaled);
    const double of_scale = true_error(table.theta); /* 0.1 mm of 50 mm, mean of its size */
    assert_true(part > 0.6 * of_scale && part < of_scale);
    for (int k = 0; k < data.n_distances; k++) data.distances[k].artefact = k;
    assert_true(calibrate()->error_here_distance_m < 0.6 * part);
    for (int k = 0; k < data.n_distances; k++)
        data.distances[k].artefact = 0, data.distances[k].sigma = 1e-5;
    assert_true(calibrate()->error_here_distance_m < 0.2 * part);
    assert_true(table.acceptance.error_here_high_m < as_printed);
}

/* Each sample three times: nothing becomes surer. */
TEST(repeated_postures_count_once)
{
    mukca_tip_error once, thrice;
    mukca_offsets_init(&table, &arm.chain);
    const mukca_tip_change_task task = {.chain = &arm.chain, .to = &table, .data = &data};
    assert_ok(mukca_tip_error_expect(&once, &task, &error));
    scene thrice_as_long = arm;
    thrice_as_long.how.rows *= 3;
    mukca_dataset all;
    record(&all, &thrice_as_long);
    const size_t n = (size_t)data.n_joints;
    for (int i = 0; i < all.n_rows; i++)
        memcpy(all.q + (size_t)i * n, data.q + (size_t)(i / 3) * n, n * sizeof *all.q);
    const mukca_tip_change_task again = {.chain = &arm.chain, .to = &table, .data = &all};
    assert_ok(mukca_tip_error_expect(&thrice, &again, &error));
    assert_int_equal(thrice.postures, once.postures);
    assert_close(thrice.after_m[0], once.after_m[0], 1e-9);
    double before[3] = {3e-3, 3e-3, 5e-3}, after[3] = {1e-3, 1e-3, 1e-3};
    mukca_difference d;
    all.n_rows = 3; /* one posture; then two of them */
    assert_ok(mukca_difference_find(&d, before, after, &all, &error));
    assert_int_equal(d.postures, 1);
    assert_true(isinf(d.sigma_m));
    memcpy(all.q + 2 * n, data.q + n, n * sizeof *all.q);
    assert_ok(mukca_difference_find(&d, before, after, &all, &error));
    assert_int_equal(d.postures, 2);
    assert_close(d.mean_m, -3e-3, 1e-15);
    assert_close(d.sigma_m, 1e-3, 1e-15);
    mukca_dataset_free(&all);
}

TEST(a_stuck_encoder_is_refused)
{
    for (int i = 0; i < data.n_rows; i++) data.q[i * data.n_joints + 3] = data.q[3];
    refused_for("");
    assert_string_equal(table.acceptance.at_rest, mukca_chain_joint_name(&arm.chain, 3));
}

/* The ball is 2 mm off the axis of the last joint: small errors, across that axis. */
TEST(a_stuck_last_joint_is_refused)
{
    const int tip = arm.chain.n_elements - 1;
    arm.arm.geometry.origin[tip].p[0] = arm.chain.element[tip].xyz[0] = 2e-3;
    mukca_dataset_free(&data);
    record(&data, &arm);
    for (int i = 0; i < data.n_rows; i++) data.q[i * data.n_joints + 6] = data.q[6];
    refused_for("joint_7 did not move, but");
}

/* Three samples of another placement: hundreds of mm. */
TEST(gross_errors_are_no_outliers)
{
    for (int i = 0; i < 3; i++) data.socket[20 + i] = data.n_sockets - 1;
    refused_for("do not fit this arm");
}

/* Samples of another socket spoil the fit, not the judgement. */
TEST(deviating_samples_are_counted)
{
    for (int i = 0; i < 8; i++) data.socket[20 + i] ^= 1;
    refused_for("8 of ");
    assert_part(table.acceptance.reason, "deviate from the others, by up to 5");
    assert_part(table.acceptance.reason, "(rows 21, 22, 23, ");
}

/* An encoder counts from another zero. */
TEST(another_zero_is_another_arm)
{
    for (int i = 0; i < data.n_rows; i++) data.q[i * data.n_joints + 1] += 0.2;
    refused_for("check the URDF, joint zeros");
}

TEST_EACH(set_up, tear_down)
