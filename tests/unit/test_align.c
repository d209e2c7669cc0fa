/* Frames of measured poses: recovered from simulated ones, whatever their rotation. */
#include "close.h"
#include "fit/align.h"
#include "gen3.h"
#include "math/random.h"

enum { ROWS = 40 };

typedef struct {
    mukca_chain chain;
    mukca_geometry geometry;
    mukca_dataset data;
    double q[ROWS * 7], position[ROWS * 3], quaternion[ROWS * 4];
    int socket[ROWS];
    mukca_frame tracker, target;
} poses;

static poses p;
static mukca_alignment found;
static const mukca_align_options both = {.tracker = true, .target = true};
static const mukca_frame identity = {.R = MUKCA_IDENTITY};

/* Pose of a target on the flange in row i, as a tracker sees it. */
static mukca_frame see(const mukca_frame *tracker, int i, const mukca_frame *target)
{
    mukca_frame pose;
    mukca_fk_pose(&pose, &p.geometry, p.q + 7 * i, NULL);
    mukca_frame_multiply(&pose, &pose, target);
    mukca_frame_multiply(&pose, tracker, &pose);
    return pose;
}

/* Poses of a target that is turned by `angle` about `axis` on the flange. */
static void measure(const double axis[3], double angle)
{
    const double tracker_rpy[3] = {0.4, -1.1, 2.5};
    mukca_random random = mukca_random_seeded(5);
    memset(&p, 0, sizeof p);
    gen3_chain(&p.chain);
    mukca_geometry_set(&p.geometry, &p.chain, NULL);
    p.tracker = (mukca_frame){.p = {1.5, -2.0, 0.7}};
    p.target = (mukca_frame){.p = {0.08, -0.03, 0.15}};
    mukca_rotation_from_rpy(p.tracker.R, tracker_rpy);
    mukca_rotation_about(p.target.R, axis, angle);
    for (int i = 0; i < ROWS; i++) {
        for (int j = 0; j < 7; j++) p.q[7 * i + j] = 4 * mukca_random_uniform(&random) - 2;
        const mukca_frame pose = see(&p.tracker, i, &p.target);
        memcpy(p.position + 3 * i, pose.p, sizeof pose.p);
        mukca_rotation_to_quaternion(p.quaternion + 4 * i, pose.R);
        p.socket[i] = -1;
    }
    p.data = (mukca_dataset){.n_rows = ROWS,
                             .n_joints = 7,
                             .q = p.q,
                             .position = p.position,
                             .quaternion = p.quaternion,
                             .socket = p.socket};
}

/* Exact data: the weak prior on the reach of the target is left, (5 mm / 0.3 m)^2 / 40 of 0.15 m.
 */
TEST(test_any_turn)
{
    static const double axes[3][3] = {{1, 0, 0}, {0, 0.6, 0.8}, {0.6, -0.64, 0.48}};
    for (int a = 0; a < 3; a++)
        for (int degrees = 0; degrees <= 180; degrees += 45) {
            const double angle = degrees * acos(-1.0) / 180;
            measure(axes[a], angle);
            assert_true(mukca_align(&found, &p.geometry, &p.data, &both));
            assert_frame(&found.tracker, &p.tracker, 2e-6);
            assert_frame(&found.target, &p.target, 2e-6);
        }
}

/* Positions alone give the tracker and the target's place. */
TEST(test_positions)
{
    measure((const double[3]){0, 0, 1}, 2.0);
    p.data.quaternion = NULL;
    assert_true(mukca_align(&found, &p.geometry, &p.data, &both));
    assert_frame(&found.tracker, &p.tracker, 5e-6);
    for (int c = 0; c < 3; c++) assert_close(found.target.p[c], p.target.p[c], 5e-6);
}

/* Three wild rows of forty and a nominal arm that is off by millimetres: frames within as much. */
TEST(test_robust)
{
    measure((const double[3]){1, 0, 0}, 2.0);
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < 3; c++) p.position[3 * (7 + 11 * k) + c] += 0.5;
    for (int k = 0; k < 7; k++) p.geometry.origin[k].p[1] += 1e-3;
    assert_true(mukca_align(&found, &p.geometry, &p.data, &both));
    assert_frame(&found.tracker, &p.tracker, 10e-3);
    assert_frame(&found.target, &p.target, 10e-3);
    assert_true(found.median_m < 5e-3);
}

/* Errors of an arm, some five times their median, are no wild rows: the mean of what least squares
 * leave is 0. */
TEST(test_least_squares)
{
    double mean[3] = {0};
    measure((const double[3]){1, 0, 0}, 0);
    for (int i = 0; i < ROWS; i++) p.position[3 * i] += i % 9 ? 1e-3 * (i % 2 ? 1 : -1) : 5e-3;
    assert_true(mukca_align(&found, &p.geometry, &p.data, &both));
    for (int i = 0; i < ROWS; i++) {
        const mukca_frame pose = see(&found.tracker, i, &found.target);
        for (int c = 0; c < 3; c++) mean[c] += (pose.p[c] - p.position[3 * i + c]) / ROWS;
    }
    for (int c = 0; c < 3; c++) assert_close(mean[c], 0, 1e-6);
}

/* Measure again with joints 2, 4 and 6, whose axes are parallel, in a plane (`line`: nearly along a
 * line) without turning the tool; noise of 20 um and 0.2 mrad. */
static void keep_orientation(bool line)
{
    mukca_random random = mukca_random_seeded(3);
    measure((const double[3]){0, 1, 0}, 1.0);
    for (int i = 0; i < ROWS; i++) {
        double noise[3], R[9], *q = p.q + 7 * i;
        memset(q, 0, 7 * sizeof *q);
        q[1] = 0.4 + 0.01 * i * (line ? 0.1 : 1), q[3] = line ? 0.9 : 1.2 * sin(i),
        q[5] = -q[1] - q[3];
        mukca_frame pose = see(&p.tracker, i, &p.target);
        for (int c = 0; c < 3; c++) {
            p.position[3 * i + c] = pose.p[c] + 2e-5 * mukca_random_normal(&random);
            noise[c] = 2e-4 * mukca_random_normal(&random);
        }
        mukca_rotation_exp(R, noise);
        mukca_mat3_mul(pose.R, R, pose.R);
        mukca_rotation_to_quaternion(p.quaternion + 4 * i, pose.R);
    }
}

/* Largest angle between measured and aligned orientations, rad. */
static double turn_left(void)
{
    double most = 0;
    for (int i = 0; i < ROWS; i++) {
        double R[9];
        const mukca_frame pose = see(&found.tracker, i, &found.target);
        mukca_rotation_from_quaternion(R, p.quaternion + 4 * i);
        most = fmax(most, mukca_rotation_between(R, pose.R));
    }
    return most;
}

/* Relative rotations are noise where the tool keeps its orientation; the orientations themselves
 * fit as well as in any other log, and what is not determined is named. */
TEST(test_constant_orientation)
{
    for (int line = 0; line < 2; line++) {
        keep_orientation(line);
        assert_true(mukca_align(&found, &p.geometry, &p.data, &both));
        assert_true(found.mean_m < 6e-5);
        assert_true(turn_left() < 1e-3);
        assert_true(line ? found.open_turn : found.open_target && !found.open_turn);
        assert_true(mukca_norm3(found.target.p) < 0.3);
    }
    measure((const double[3]){0, 1, 0}, 1.0);
    assert_true(mukca_align(&found, &p.geometry, &p.data, &both));
    assert_true(!found.open_turn && !found.open_target);
}

/* A tip that moves along a line, with a tool that keeps its orientation: positions alone determine
 * the line, not the turn about it, which stays as it is. */
TEST(points_on_one_line)
{
    const double from[3] = {0.6, 0, 0.8},
                 to[4][3] = {{0, 1, 0}, {0.6, 0, 0.8}, {-0.6, 0, -0.8}, {0.8, 0, -0.6}};
    for (int i = 0; i < 4; i++) {
        double R[9] = MUKCA_IDENTITY, H[9], on[3], square[9];
        for (int k = 0; k < 9; k++) H[k] = from[k / 3] * to[i][k % 3];
        mukca_rotation_nearest(R, H);
        mukca_mat3_vec(on, R, from);
        for (int k = 0; k < 3; k++) assert_close(on[k], to[i][k], 1e-12);
        mukca_mat3_tmul(square, R, R);
        for (int k = 0; k < 9; k++) assert_close(square[k], k % 4 == 0, 1e-12);
        assert_close(mukca_rotation_between(R, identity.R), acos(mukca_dot3(from, to[i])), 1e-7);
    }
    measure((double[]){0, 0, 1}, 0);
    p.data.quaternion = NULL;
    mukca_chain line = p.chain; /* slides on a line: the first joint alone moves the tip */
    line.element[line.joint_element[0]].type = MUKCA_PRISMATIC;
    mukca_geometry_set(&p.geometry, &line, NULL);
    for (int i = 0; i < ROWS; i++) {
        for (int j = 1; j < 7; j++) p.q[7 * i + j] = 0.3;
        const mukca_frame pose = see(&p.tracker, i, &identity);
        memcpy(p.position + 3 * i, pose.p, sizeof pose.p);
    }
    assert_true(mukca_align(&found, &p.geometry, &p.data, &both));
    assert_true(found.mean_m < 1e-6);
    assert_true(found.open_turn);
}

/* Nothing to align: identity. */
TEST(test_nothing)
{
    measure((const double[3]){1, 0, 0}, 1.0);
    assert_true(mukca_align(&found, &p.geometry, &p.data, &(mukca_align_options){0}));
    assert_frame(&found.tracker, &identity, 0);
    p.data.n_rows = 2;
    assert_true(mukca_align(&found, &p.geometry, &p.data, &both));
    assert_frame(&found.target, &identity, 0);
    assert_true(isnan(found.median_m));
}

TEST_MAIN(NULL, NULL)
