/* Re-calibration finds the paper's offsets, lag and frames besides. */
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
    log->position = zeroed(3 * MAX_ROWS, sizeof *log->position);
    log->quaternion = zeroed(4 * MAX_ROWS, sizeof *log->quaternion);
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

/* The true arm, by the definition T_n = [R(q + dq), p + dp] and not through the pose model; no test
 * data. */
FIXTURE(build_truth)
{
    gen3_chain(&nominal);
    truth = nominal;
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < 3; i++) truth.element[k].xyz[i] += gen3_dp[k][i];
    for (int j = 0; j < 7; j++) zeros[j] = gen3_dq[j];
    test.n_rows = 0;
    return 0;
}

enum { SWEEPS, RASTER }; /* one joint after the other, the others at 0; random postures */

static void record(mukca_dataset *log, int kind)
{
    mukca_random random = mukca_random_seeded(1);
    mukca_geometry geometry;
    mukca_geometry_set(&geometry, &truth, NULL);
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

static mukca_status run(const mukca_fit_options *options, bool robust)
{
    mukca_dataset log = as_log(&train), check = as_log(&test);
    mukca_status status = mukca_recalibrate(
        &result, &nominal, &log, options ? options : &(mukca_fit_options){0}, robust, &error);
    for (int k = 0; k < MUKCA_STAGES && status == MUKCA_OK; k++)
        if (result.has_angles || k != MUKCA_WITH_ANGLES)
            status = mukca_pose_errors_find(&errors[k], &result.stage[k], &check, &error);
    mukca_dataset_free(&log);
    mukca_dataset_free(&check);
    return status;
}

static mukca_status check_log(mukca_pose_check *check, bool free_frames)
{
    mukca_dataset log = as_log(&train);
    const mukca_status status = mukca_pose_check_run(check, &nominal, &log, free_frames, &error);
    mukca_dataset_free(&log);
    return status;
}

static double zero_of(int joint, double *sigma)
{
    for (int i = 0; i < result.lengths.parameters.n; i++) {
        mukca_unknown u;
        mukca_split_arm_name(&u, &result.split, &nominal, &result.lengths, i);
        if (u.element != joint || !strstr(u.text, " zero")) continue;
        const int at = result.lengths.parameters.index[i];
        if (sigma) *sigma = result.lengths.identification.sigma[i];
        return u.sign * (result.lengths.theta[at] - result.start[at]);
    }
    return (double)NAN;
}

/* The acceptance of the paper's Table 3 without noise: logs that were not seen. */
TEST(test_paper)
{
    record(&train, SWEEPS);
    record(&test, RASTER);
    assert_ok(run(NULL, false));
    /* The paper: 9.1 +- 2.7 mm, at most 19.4 */
    assert_close(result.errors[MUKCA_BEFORE].position.length.mean, 9.1e-3, 0.5e-3);
    assert_close(result.errors[MUKCA_BEFORE].position.length.max, 19.4e-3, 2e-3);
    assert_true(result.errors[MUKCA_WITH_ANGLES].position.length.mean <
                result.errors[MUKCA_BEFORE].position.length.mean);
    assert_int_equal(result.lengths.parameters.n, 31);
    assert_int_equal(result.lengths.identification.rank, 7 + 17);
    assert_true(result.lag == 0);
    for (int j = 0; j < 7; j++) assert_close(zero_of(j, NULL), gen3_dq[j], 1e-8);
    for (int k = MUKCA_WITH_LENGTHS; k < MUKCA_STAGES; k++) {
        assert_close(errors[k].position.length.max, 0, 2e-9);
        assert_close(errors[k].rotation.length.max, 0, 2e-9);
        assert_int_equal(errors[k].position.length.n, 165);
    }

    for (int i = 0; i < train.n_rows; i++) train.quaternion[4 * i] = (double)NAN;
    assert_ok(run(NULL, false)); /* positions alone */
    assert_false(result.has_angles);
    assert_close(result.errors[MUKCA_WITH_ALL].position.length.max, 0, 1e-7);
}

/* Axes that lean and a tool that is turned are no zeros and lengths: what the restriction leaves,
 * all parameters remove. */
TEST(test_axes)
{
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < 3; i++) truth.element[k].rpy[i] += 2e-3 * ((k + i) % 3 - 1);
    record(&train, RASTER);
    record(&test, RASTER);
    assert_ok(run(NULL, false));
    assert_true(errors[MUKCA_WITH_LENGTHS].position.length.mean > 3e-4);
    assert_close(errors[MUKCA_WITH_ALL].position.length.max, 0, 1e-7);
    assert_close(errors[MUKCA_WITH_ALL].rotation.length.max, 0, 1e-6);
}

/* Joints about axes that are none of their frame's have a zero, too; a split arm is the arm. */
TEST(test_split)
{
    mukca_split_arm split;
    mukca_geometry whole, parts;
    mukca_frame a, b;
    const double q[7] = {0.1, -0.7, 1.2, 0.4, -1.1, 0.3, 2}, axis[3] = {0.6, 0, -0.8};
    memcpy(nominal.element[3].axis, axis, sizeof axis);
    for (int i = 0; i < 3; i++) nominal.element[3].rpy[i] = 0.3 - 0.4 * i; /* a general rotation */
    for (int i = 0; i < 3; i++) nominal.element[5].axis[i] = i == 1;
    assert_ok(mukca_split_arm_set(&split, &nominal, &error));
    mukca_geometry_set(&whole, &nominal, NULL);
    mukca_geometry_set(&parts, &split.chain, NULL);
    mukca_fk_pose(&a, &whole, q, NULL);
    mukca_fk_pose(&b, &parts, q, NULL);
    assert_frame(&a, &b, 1e-14);
    for (int j = 0; j < 7; j++) { /* a zero is the same turn as the joint's */
        double theta[MUKCA_MAX_FREE], moved[7];
        mukca_chain_theta(theta, &split.chain);
        theta[6 * split.chain.joint_element[j] + 3 + split.axis[j]] += split.sign[j] * 0.01;
        mukca_geometry_set(&parts, &split.chain, theta);
        memcpy(moved, q, sizeof moved);
        moved[j] += 0.01;
        mukca_fk_pose(&a, &whole, moved, NULL);
        mukca_fk_pose(&b, &parts, q, NULL);
        for (int i = 0; i < 3; i++) assert_close(a.p[i], b.p[i], 1e-14);
    }
    nominal.n_elements = MUKCA_MAX_ELEMENTS;
    assert_refused(mukca_split_arm_set(&split, &nominal, &error), "use calibrate");
}

static void add_noise(mukca_dataset *log, double metres, double radians, uint64_t seed)
{
    mukca_random random = mukca_random_seeded(seed);
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
    record(&train, SWEEPS);
    add_noise(&train, 1e-4, 2e-4, 3);
    assert_ok(run(NULL, false));
    for (int j = 0; j < 7; j++) {
        double sigma = 0;
        const double zero = zero_of(j, &sigma);
        assert_true(sigma > 1e-6 && sigma < 2e-4);
        assert_close(zero, gen3_dq[j], 4 * sigma);
    }
    assert_close(result.tail, 1, 0.1);
    assert_true(result.calibrated && !result.trimmed);

    /* One row in twenty is centimetres off. */
    for (int i = 0; i < train.n_rows; i += 20) train.position[3 * i + i % 3] += 0.03;
    assert_ok(run(NULL, false));
    const double plain = result.errors[MUKCA_WITH_ALL].position.median;
    assert_true(result.tail > 2 && result.trimmed);
    assert_ok(run(NULL, true));
    assert_close(result.errors[MUKCA_WITH_ALL].position.median, 1.538e-4, 0.1e-4);
    assert_true(plain > 2e-4);
}

/* Rows while all joints swing; poses taken 30 ms after the angles, 100 rows per second. */
static void record_swing(double lag)
{
    mukca_geometry geometry;
    mukca_geometry_set(&geometry, &truth, NULL);
    create(&train);
    train.time = zeroed(MAX_ROWS, sizeof *train.time);
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
    record_swing(0);
    assert_ok(run(NULL, false));
    assert_true(result.lag == 0);
    record_swing(0.03);
    assert_ok(run(NULL, false));
    assert_close(result.lag, 0.03, 3e-4);
    for (int j = 0; j < 7; j++) assert_close(zero_of(j, NULL), gen3_dq[j], 5e-4);
    train.n_rows = 30; /* a short log */
    assert_ok(run(NULL, false));
    assert_close(result.lag, 0.03, 3e-3);
    train.n_rows = MAX_ROWS;
    for (int i = 0; i < train.n_rows; i++) train.time[i] = (double)NAN;
    assert_ok(run(NULL, false));
    assert_close(result.lag, 3, 0.03);
    for (int i = 0; i < train.n_rows; i++) train.quaternion[4 * i] = (double)NAN;
    assert_ok(run(NULL, false));
    assert_close(result.lag, 3, 0.03);
}

TEST(test_frames)
{
    mukca_pose_check check;
    mukca_frame base, tool = {{0}, {0, 0, 0}}, T, M;
    const double w[3] = {0.2, -0.4, 2.0}, v[3] = {0.1, 0.2, 0.3};
    record(&train, RASTER);
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
    assert_ok(run(&(mukca_fit_options){.free_base = true, .free_tool = true}, false));
    for (int k = MUKCA_WITH_LENGTHS; k < MUKCA_STAGES; k++) {
        assert_close(result.errors[k].position.length.max, 0, 1e-8);
        assert_close(result.errors[k].rotation.length.max, 0, 1e-7);
    }

    /* Positions of the tip, orientations of a link before it. */
    record(&train, RASTER);
    const double half_turn[9] = {1, 0, 0, 0, -1, 0, 0, 0, -1}; /* the tip's fixed turn */
    for (int i = 0; i < train.n_rows; i++) {
        mukca_rotation_from_quaternion(T.R, train.quaternion + 4 * i);
        mukca_mat3_mul(M.R, T.R, half_turn);
        mukca_rotation_to_quaternion(train.quaternion + 4 * i, M.R);
    }
    assert_ok(check_log(&check, false));
    assert_int_equal(check.position_element, 7);
    assert_int_equal(check.rotation_element, 6);
    for (int i = 0; i < 9; i++) assert_close(check.turn[i], half_turn[i], 1e-12);
}

/* What no file can show: poses of other rows, a row that is no number. */
TEST(test_bad_input)
{
    mukca_pose_check check;
    record(&train, RASTER);
    for (int i = 0; 2 * i + 1 < train.n_rows; i++)
        memcpy(train.position + 3 * i, train.position + 3 * (train.n_rows - 1 - i),
               3 * sizeof *train.position);
    train.n_rows /= 2;
    assert_int_equal(check_log(&check, false), MUKCA_INPUT);
    record(&train, RASTER);
    train.q[7 * 9 + 2] = (double)NAN;
    assert_int_equal(run(NULL, false), MUKCA_INPUT);
}

/* Velocities are differences of neighbours; no motion connects two files, and a row without a
 * position is none. */
TEST(test_velocities)
{
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

TEST_EACH(build_truth, NULL)
