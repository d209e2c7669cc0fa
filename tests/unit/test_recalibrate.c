/* Re-calibration finds the paper's offsets to 1e-12, lag and frames besides, and no calibration
 * in noise. */
#include <stdlib.h>
#include <string.h>

#include "close.h"
#include "gen3.h"
#include "math/random.h"
#include "model/dataset_subset.h"
#include "recalibrate/recalibrate.h"
#include "simulate/simulate.h"

enum { MAX_ROWS = 2000 };

/* Rows as they are recorded, with n_rows of MAX_ROWS in use. */
static mukca_dataset train, test;

static void create(mukca_dataset *log)
{
    mukca_dataset_free(log);
    assert_ok(mukca_dataset_create(log, MAX_ROWS, 7, 0, 0, &error));
    log->position = calloc(3 * MAX_ROWS, sizeof *log->position);
    log->quaternion = calloc(4 * MAX_ROWS, sizeof *log->quaternion);
    assert_true(log->position && log->quaternion);
}

/* As a log, to be freed. */
static mukca_dataset as_log(const mukca_dataset *rows)
{
    unsigned char all[MAX_ROWS];
    mukca_dataset log;
    memset(all, 1, sizeof all);
    assert_ok(mukca_dataset_subset(&log, rows, all, &error));
    assert_ok(mukca_pose_log_prepare(&log, &error));
    return log;
}

static mukca_recalibration result;
static mukca_pose_errors errors[MUKCA_STAGES];
static mukca_chain nominal, truth; /* truth: origins with the offsets */
static double zeros[MUKCA_MAX_JOINTS];

/* The true arm, by the definition T_n = [R(q + dq), p + dp] and not through the pose model. */
static void build_truth(double scale)
{
    gen3_chain(&nominal);
    truth = nominal;
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < 3; i++) truth.element[k].xyz[i] += scale * gen3_dp[k][i];
    for (int j = 0; j < 7; j++) zeros[j] = scale * gen3_dq[j];
}

enum { SWEEPS, RASTER }; /* one joint after the other, the others at 0; random postures */

static void record(mukca_dataset *log, int kind)
{
    mukca_random random;
    mukca_geometry geometry;
    mukca_geometry_set(&geometry, &truth, NULL);
    mukca_random_seed(&random, 1);
    create(log);
    log->n_rows = kind == SWEEPS ? 7 * 277 : 165;
    for (int i = 0; i < log->n_rows; i++) {
        const int j = i / 277, at = i % 277; /* from 0 to the upper end, then to the lower end */
        const double reach = j % 2 ? M_PI / 2 : M_PI, x = 3.0 * at / 277;
        if (kind == SWEEPS)
            log->q[7 * i + j] = reach * (x < 1 ? x : 2 - x);
        else
            mukca_simulate_posture(log->q + 7 * i, &nominal, &random);
    }
    for (int i = 0; i < log->n_rows; i++) {
        double moved[7];
        mukca_frame tip;
        for (int j = 0; j < 7; j++) moved[j] = log->q[7 * i + j] + zeros[j];
        mukca_fk_pose(&tip, &geometry, moved, NULL);
        memcpy(log->position + 3 * i, tip.p, sizeof tip.p);
        mukca_rotation_to_quaternion(log->quaternion + 4 * i, tip.R);
    }
}

static mukca_status run(const mukca_recalibrate_options *options)
{
    mukca_dataset log = as_log(&train), check = as_log(&test);
    const mukca_recalibrate_options none = {0};
    if (!options) options = &none;
    const mukca_recalibrate_task fit = {&nominal, &log, options},
                                 held_out = {&nominal, &check, options};
    mukca_status status = mukca_recalibrate(&result, &fit, &error);
    if (status == MUKCA_OK && test.n_rows > 0)
        status = mukca_recalibrate_test(errors, result.stage, MUKCA_STAGES, &held_out, &error);
    mukca_dataset_free(&log);
    mukca_dataset_free(&check);
    return status;
}

static mukca_status check_log(mukca_pose_check *check, bool free_frames)
{
    const mukca_recalibrate_options options = {.free_base = free_frames, .free_tool = free_frames};
    mukca_dataset log = as_log(&train);
    const mukca_status status =
        mukca_pose_check_run(check, &(mukca_recalibrate_task){&nominal, &log, &options}, &error);
    mukca_dataset_free(&log);
    return status;
}

static double zero_of(int joint)
{
    for (int u = 0; u < result.found.n; u++)
        if (result.found.unknown[u].kind == MUKCA_UNKNOWN_ZERO &&
            result.found.unknown[u].element == joint)
            return result.found.value[u];
    return (double)NAN;
}

/* The acceptance of the paper's Table 3 without noise: logs that were not seen. */
TEST(test_paper)
{
    build_truth(1);
    record(&train, SWEEPS);
    record(&test, RASTER);
    assert_ok(run(NULL));
    /* The paper: 9.1 +- 2.7 mm, at most 19.4 */
    assert_close(result.errors[MUKCA_BEFORE].position.length.mean, 9.1e-3, 0.5e-3);
    assert_close(result.errors[MUKCA_BEFORE].position.length.max, 19.4e-3, 2e-3);
    assert_true(result.errors[MUKCA_WITH_ANGLES].position.length.mean <
                result.errors[MUKCA_BEFORE].position.length.mean);
    assert_true(result.errors[MUKCA_WITH_BOTH].position.length.max < 1e-6); /* one pass */
    assert_int_equal(result.found.n, 31);
    assert_int_equal(result.found.rank, 7 + 17);
    assert_int_equal(result.found.n_null, 7);
    assert_true(result.lag == 0);
    const mukca_recalibrate_options options = {.iterate = true};
    assert_ok(run(&options));
    for (int j = 0; j < 7; j++) assert_close(zero_of(j), gen3_dq[j], 1e-12);
    assert_close(errors[MUKCA_WITH_BOTH].position.length.max, 0, 2e-9);
    assert_close(errors[MUKCA_WITH_BOTH].rotation.length.max, 0, 2e-9);
    assert_int_equal(errors[MUKCA_WITH_BOTH].position.length.n, 165);

    /* Shifts that cannot be told are along the joints' own axes; adding any leaves poses alone. */
    mukca_pose_model moved = result.stage[MUKCA_WITH_BOTH];
    for (int k = 0; k < result.found.n_null; k++)
        for (int u = 0; u < result.found.n; u++)
            mukca_pose_model_add(&moved, &result.found.unknown[u],
                                 1e-3 * (k + 1) * result.found.null[k][u]);
    mukca_pose_look a, b;
    mukca_dataset log = as_log(&test);
    mukca_pose_look_at(&a, &moved, &log, 7);
    mukca_pose_look_at(&b, &result.stage[MUKCA_WITH_BOTH], &log, 7);
    mukca_dataset_free(&log);
    for (int i = 0; i < 3; i++) assert_close(a.tip.p[i], b.tip.p[i], 1e-9);
}

TEST(test_joint_solution)
{
    const mukca_recalibrate_options options = {.iterate = true, .joint = true};
    build_truth(1);
    record(&train, SWEEPS);
    record(&test, RASTER);
    assert_ok(run(&options));
    assert_close(errors[MUKCA_WITH_BOTH].position.length.max, 0, 2e-9);
    assert_close(errors[MUKCA_WITH_BOTH].rotation.length.max, 0, 2e-9);
    /* Positions alone, axes free to lean. */
    for (int i = 0; i < train.n_rows; i++) train.quaternion[4 * i] = (double)NAN;
    const mukca_recalibrate_options tilts = {.tilts = true};
    assert_ok(run(&tilts));
    assert_close(result.errors[MUKCA_WITH_BOTH].position.length.max, 0, 1e-7);
}

static void add_noise(mukca_dataset *log, double metres, double radians, uint64_t seed)
{
    mukca_random random;
    mukca_random_seed(&random, seed);
    for (int i = 0; i < log->n_rows; i++) {
        double w[3], R[9], E[9], turned[9];
        for (int a = 0; a < 3; a++) {
            log->position[3 * i + a] += metres * mukca_random_normal(&random);
            w[a] = radians * mukca_random_normal(&random);
        }
        mukca_rotation_from_quaternion(R, log->quaternion + 4 * i);
        mukca_rotation_exp(E, w);
        mukca_mat3_mul(turned, R, E);
        mukca_rotation_to_quaternion(log->quaternion + 4 * i, turned);
    }
}

TEST(test_noise)
{
    build_truth(1);
    record(&train, SWEEPS);
    add_noise(&train, 1e-4, 2e-4, 3);
    test.n_rows = 0;
    const mukca_recalibrate_options options = {.iterate = true};
    assert_ok(run(&options));
    for (int j = 0; j < 7; j++) {
        assert_true(result.found.sigma[j] > 1e-6 && result.found.sigma[j] < 5e-5);
        assert_close(zero_of(j), gen3_dq[j], 4 * result.found.sigma[j]);
    }
    assert_close(result.tail, 1, 0.1);
    assert_true(result.calibrated);

    /* Huber against one row in twenty that is centimetres off. */
    for (int i = 0; i < train.n_rows; i += 20) train.position[3 * i + i % 3] += 0.03;
    const mukca_recalibrate_options robust = {.robust = true};
    assert_ok(run(NULL));
    const double plain = result.errors[MUKCA_WITH_BOTH].position.median;
    assert_true(result.tail > 2);
    assert_ok(run(&robust));
    assert_close(result.errors[MUKCA_WITH_BOTH].position.median, 1.538e-4, 0.1e-4);
    assert_true(plain > 2e-4);

    build_truth(0); /* poses that only repeat the nominal model */
    record(&train, SWEEPS);
    add_noise(&train, 1e-4, 2e-4, 4);
    assert_ok(run(NULL));
    assert_false(result.calibrated);
}

/* Rows while all joints swing; poses taken 30 ms after the angles, 100 rows per second. */
static void record_swing(double lag)
{
    mukca_geometry geometry;
    mukca_geometry_set(&geometry, &truth, NULL);
    create(&train);
    train.time = calloc(MAX_ROWS, sizeof *train.time);
    assert_non_null(train.time);
    for (int i = 0; i < train.n_rows; i++) {
        const double t = 0.01 * i;
        double q[7];
        mukca_frame tip;
        train.time[i] = t;
        for (int j = 0; j < 7; j++) {
            train.q[7 * i + j] = 1.2 * sin((0.7 + 0.13 * j) * t + j);
            q[j] = 1.2 * sin((0.7 + 0.13 * j) * (t + lag) + j) + zeros[j];
        }
        mukca_fk_pose(&tip, &geometry, q, NULL);
        memcpy(train.position + 3 * i, tip.p, sizeof tip.p);
        mukca_rotation_to_quaternion(train.quaternion + 4 * i, tip.R);
    }
    add_noise(&train, 2e-5, 2e-5, 6);
}

TEST(test_lag)
{
    test.n_rows = 0;
    build_truth(1);
    record_swing(0);
    assert_ok(run(NULL));
    assert_true(result.lag == 0);
    record_swing(0.03);
    assert_ok(run(NULL));
    assert_close(result.lag, 0.03, 3e-4);
    for (int j = 0; j < 7; j++) assert_close(zero_of(j), gen3_dq[j], 5e-4);
    train.n_rows = 30; /* less than a block of equations */
    assert_ok(run(NULL));
    assert_close(result.lag, 0.03, 3e-3);
    train.n_rows = MAX_ROWS;
    for (int i = 0; i < train.n_rows; i++) train.time[i] = (double)NAN;
    assert_ok(run(NULL));
    assert_close(result.lag, 3, 0.03);
    for (int i = 0; i < train.n_rows; i++) train.quaternion[4 * i] = (double)NAN;
    const mukca_recalibrate_options tilts = {.tilts = true};
    assert_ok(run(&tilts));
    assert_close(result.lag, 3, 0.03);
}

TEST(test_frames)
{
    mukca_pose_check check;
    mukca_frame base, tool = {{0}, {0, 0, 0}}, T, M;
    const double w[3] = {0.2, -0.4, 2.0}, v[3] = {0.1, 0.2, 0.3};
    build_truth(1);
    record(&train, RASTER);
    test.n_rows = 0;
    mukca_rotation_exp(base.R, w);
    mukca_rotation_exp(tool.R, v);
    base.p[0] = 1, base.p[1] = -2, base.p[2] = 0.5;
    for (int i = 0; i < train.n_rows; i++) {
        mukca_rotation_from_quaternion(T.R, train.quaternion + 4 * i);
        memcpy(T.p, train.position + 3 * i, sizeof T.p);
        mukca_frame_multiply(&M, &base, &T);
        mukca_frame_multiply(&M, &M, &tool);
        mukca_rotation_to_quaternion(train.quaternion + 4 * i, M.R);
        memcpy(train.position + 3 * i, M.p, sizeof M.p);
    }
    assert_refused(check_log(&check, false), "--free-base");
    assert_ok(check_log(&check, true));
    const mukca_recalibrate_options options = {.iterate = true,
                                               .joint = true,
                                               .free_base = true,
                                               .free_tool = true,
                                               .base = check.base,
                                               .tool = check.tool};
    assert_ok(run(&options));
    assert_close(result.errors[MUKCA_WITH_BOTH].position.length.max, 0, 1e-8);
    assert_close(result.errors[MUKCA_WITH_BOTH].rotation.length.max, 0, 1e-8);
    /* The base's shift is that of its own origin, not of the poses'. */
    for (int u = 0, axis = 0; u < result.found.n; u++)
        if (result.found.unknown[u].element == MUKCA_UNKNOWN_BASE &&
            result.found.unknown[u].kind == MUKCA_UNKNOWN_SHIFT) {
            assert_close(result.found.value[u],
                         result.stage[MUKCA_WITH_BOTH].base.p[axis] - check.base.p[axis], 1e-12);
            axis++;
        }

    /* Positions of the tip, orientations of a link before it. */
    record(&train, RASTER);
    for (int i = 0; i < train.n_rows; i++) {
        const double half_turn[9] = {1, 0, 0, 0, -1, 0, 0, 0, -1}; /* the tip's fixed turn */
        mukca_rotation_from_quaternion(T.R, train.quaternion + 4 * i);
        mukca_mat3_mul(M.R, T.R, half_turn);
        mukca_rotation_to_quaternion(train.quaternion + 4 * i, M.R);
    }
    assert_ok(check_log(&check, false));
    assert_int_equal(check.position_element, 7);
    assert_int_equal(check.rotation_element, 6);
    const mukca_recalibrate_options known = {.tool = check.tool};
    assert_ok(run(&known));
    assert_close(result.errors[MUKCA_WITH_BOTH].rotation.length.max, 0, 1e-6);
}

/* What no file can show: poses of other rows, a row that is no number. */
TEST(test_bad_input)
{
    mukca_pose_check check;
    build_truth(1);
    test.n_rows = 0;
    record(&train, RASTER);
    for (int i = 0; 2 * i + 1 < train.n_rows; i++)
        memcpy(train.position + 3 * i, train.position + 3 * (train.n_rows - 1 - i),
               3 * sizeof *train.position);
    train.n_rows /= 2;
    assert_int_equal(check_log(&check, false), MUKCA_INPUT);
    record(&train, RASTER);
    train.q[7 * 9 + 2] = (double)NAN;
    assert_int_equal(run(NULL), MUKCA_INPUT);
}

/* Velocities are differences of neighbours; no motion connects two files, and a row without a
 * position is none. */
TEST(test_velocities)
{
    build_truth(1);
    record(&train, SWEEPS);
    for (int i = 0; i < train.n_rows; i++) train.file[i] = i >= 100;
    train.position[3 * 50] = (double)NAN;
    mukca_dataset log = as_log(&train);
    assert_int_equal(log.n_rows, train.n_rows - 1);
    for (int i = 1; i < 270; i++) { /* the second file begins with row 99 */
        const int from = i - (i != 99), to = i + (i != 98);
        assert_close(log.velocity[7 * i], (log.q[7 * to] - log.q[7 * from]) / (to - from), 1e-15);
    }
    mukca_dataset_free(&log);
}

TEST_MAIN(NULL, NULL)
