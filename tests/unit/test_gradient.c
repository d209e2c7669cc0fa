/* Cost, gradients and Jacobian against brute-force differences of the cost's definition. */
#include <float.h>

#include "arms.h"
#include "close.h"
#include "fit/align.h"
#include "fit/fit.h"
#include "fit/poses.h"
#include "fit/solver.h"
#include "reference_cost.h"

enum { JOINTS = 6, ELEMENTS = 9 };

/* The reference's long double has hardware on x86; in software, as on arm64, a third of the cases
 * is enough. */
enum { STEP = LDBL_MANT_DIG > 64 ? 3 : 1 };

static mukca_random seeded;
static mukca_chain chain;
static mukca_dataset data;
static double theta[MUKCA_MAX_FREE];

/* An arm of every joint type, with arbitrary axes, fixed joints in between and a fixed tip. */
static void make_arm(bool upright)
{
    make_chain(&chain, "RCFPRFCRF", NULL, "joint_", 0);
    for (int k = 0; k < ELEMENTS; k++) {
        scatter_element(&chain.element[k], 0.2, upright, &seeded);
        if (upright && k % 2) chain.element[k].axis[2] = -1;
    }
    assert_int_equal(chain.n_joints, JOINTS);
}

/* Two placements, of three and two sockets with all distances known; `poses` rows of a pose log. */
static void make_data(const double *special, int rows, int poses)
{
    static const int placement[5] = {0, 0, 0, 1, 1};
    static const mukca_distance distances[4] = {
        {0, 1, 0.31, 0, 0}, {1, 2, 0.22, 0, 0}, {0, 2, 0.4, 0, 0}, {4, 3, 0.5, 0, 0}};
    assert_ok(mukca_dataset_create(&data, rows + poses, JOINTS, 5, 2, NULL));
    for (int s = 0; s < 5; s++) data.sockets[s].placement = placement[s];
    data.position = zeroed((size_t)(3 * (rows + poses)), sizeof *data.position);
    data.quaternion = zeroed((size_t)(4 * (rows + poses)), sizeof *data.quaternion);
    data.distances = (mukca_distance *)copied(distances, sizeof distances);
    data.n_distances = 4;
    for (int i = 0; i < rows + poses; i++) {
        double length = 0;
        data.socket[i] = i < rows ? (i < 5 ? i : mukca_random_below(&seeded, 5)) : -1;
        for (int j = 0; j < JOINTS; j++)
            data.q[i * JOINTS + j] = special && i % 3 ? special[(i + j) % 4] + (i % 3 == 2 ? j : 0)
                                                      : 2 * mukca_random_normal(&seeded);
        for (int a = 0; a < 3; a++) data.position[3 * i + a] = 0.4 * mukca_random_normal(&seeded);
        for (int a = 0; a < 4; a++) {
            data.quaternion[4 * i + a] = mukca_random_normal(&seeded);
            length += data.quaternion[4 * i + a] * data.quaternion[4 * i + a];
        }
        for (int a = 0; a < 4; a++) data.quaternion[4 * i + a] /= sqrt(length);
        if (i % 4 == 1) data.quaternion[4 * i] = NAN; /* position only */
        if (i % 4 == 2) data.position[3 * i] = NAN;   /* orientation only */
    }
}

/* What is compared: all entries within tolerance of their own size or a thousandth of the largest.
 */
static void compare(const double *got, const real *want, int n, double tolerance, const char *what)
{
    real largest = 0;
    for (int i = 0; i < n; i++) largest = fmaxl(largest, fabsl(want[i]));
    for (int i = 0; i < n; i++) {
        const real scale = fmaxl(fabsl(want[i]), 1e-3L * largest);
        if (!(fabsl(got[i] - want[i]) <= tolerance * scale))
            fail_msg("%s: entry %d is %.17g, expected %.17Lg", what, i, got[i], want[i]);
    }
}

/* Fourth-order differences in long double: good to 1e-13 of the gradient. */
static void differences(real *gradient, const mukca_parameters *parameters,
                        const mukca_cost_options *options)
{
    static const real weight[4] = {1.0L / 12, -8.0L / 12, 8.0L / 12, -1.0L / 12};
    static const int at[4] = {-2, -1, 1, 2};
    const real h = 1e-4L;
    real moved[MUKCA_MAX_FREE];
    for (int i = 0; i < parameters->n; i++) {
        gradient[i] = 0;
        for (int s = 0; s < 4; s++) {
            for (int k = 0; k < 6 * chain.n_elements; k++) moved[k] = theta[k];
            moved[parameters->index[i]] += at[s] * h;
            gradient[i] +=
                weight[s] * reference_cost(&chain, &data, moved, parameters, options) / h;
        }
    }
}

/* All there is to check at one point. */
static void check_point(const mukca_selection *selection, mukca_cost_options options)
{
    mukca_parameters parameters;
    mukca_cost cost;
    mukca_cost_value parts;
    real want[MUKCA_MAX_FREE], wide[MUKCA_MAX_FREE];
    double got[2][MUKCA_MAX_FREE], x[MUKCA_MAX_FREE];
    assert_ok(mukca_parameters_select(&parameters, &chain, selection, &error));
    const int n = parameters.n;
    mukca_parameters_pack(x, &parameters, theta);
    differences(want, &parameters, &options);
    for (int k = 0; k < 6 * chain.n_elements; k++) wide[k] = theta[k];
    const real value = reference_cost(&chain, &data, wide, &parameters, &options);
    options.theta = theta;
    for (int kind = 0; kind < 2; kind++) {
        options.gradient = kind ? MUKCA_GRADIENT_ANALYTIC : MUKCA_GRADIENT_FD;
        mukca_pool pool = {0};
        assert_true(mukca_cost_setup(&cost, &pool, &chain, &parameters, &data, &options));
        const double J = mukca_cost_evaluate(&parts, got[kind], &cost, x);
        assert_close(J, (double)value, 1e-12 * (double)value);
        assert_close(parts.inconsistency + parts.distortion + parts.regularisation, J, 1e-15 * J);
        compare(got[kind], want, n, kind ? 1e-10 : 1e-8, kind ? "analytic" : "fd");

        /* the Jacobian: 2 J'W r is the gradient of what is not regularisation */
        const int m = cost.observations.n_residuals;
        mukca_observe_residuals(cost.r, cost.J, &cost.observations, theta);
        for (int c = 0; c < n; c++) {
            got[kind][c] = 0;
            for (int i = 0; i < m; i++)
                got[kind][c] += 2 * cost.weight[i] * cost.weight[i] * cost.r[i] * cost.J[i * n + c];
            if (parameters.regularised[c])
                got[kind][c] += 2 * mukca_cost_lambda(&cost) * (x[c] - cost.nominal[c]);
        }
        compare(got[kind], want, n, kind ? 1e-10 : 1e-8, "jacobian");

        /* and column by column, against differences of the residuals */
        double *high = zeroed(1, 2 * (size_t)m * sizeof *high), moved[MUKCA_MAX_FREE];
        for (int c = 0; c < n; c++) {
            for (int side = 0; side < 2; side++) {
                memcpy(moved, theta, (size_t)(6 * chain.n_elements) * sizeof *moved);
                moved[parameters.index[c]] += side ? -1e-5 : 1e-5;
                mukca_observe_residuals(high + side * m, NULL, &cost.observations, moved);
            }
            for (int i = 0; i < m; i++)
                assert_close(cost.J[i * n + c], (high[i] - high[m + i]) / 2e-5, 2e-8);
        }
        free(high);
        mukca_pool_free(&pool);
    }
}

static void off_nominal(void)
{
    mukca_chain_theta(theta, &chain);
    for (int i = 0; i < 6 * chain.n_elements; i++) theta[i] += 0.02 * mukca_random_normal(&seeded);
}

TEST(test_options)
{
    static const mukca_cost_options options[] = {{0}, {.lambda = -1}, {.lambda = 0.3}};
    seeded = mukca_random_seeded(1);
    for (int upright = 0; upright < 2; upright++) {
        make_arm(upright);
        make_data(NULL, 17, 0);
        off_nominal();
        for (size_t i = 0; i < sizeof options / sizeof *options; i += STEP)
            check_point(&(mukca_selection){0}, options[i]);
        mukca_dataset_free(&data);
    }
}

TEST(test_masks)
{
    static const mukca_selection masks[] = {{.regularise_tip = true},
                                            {.free = "joint_4"},
                                            {.free = "joint_5.pitch"},
                                            {.free = "yaw,z"},
                                            {.freeze = "x,y,z"},
                                            {.free = "+joint_3,joint_6"},
                                            {.freeze = "joint_1,joint_9.roll"},
                                            {.free = "joint_3.roll,joint_9"}};
    seeded = mukca_random_seeded(2);
    make_arm(false);
    make_data(NULL, 12, 7);
    off_nominal();
    for (size_t i = 0; i < sizeof masks / sizeof *masks; i += STEP)
        check_point(&masks[i], (mukca_cost_options){0});
    mukca_dataset_free(&data);
}

TEST(test_angles)
{
    static const double special[4] = {0, 1e-12, M_PI - 1e-9, -M_PI_2};
    seeded = mukca_random_seeded(3);
    for (int trial = 0; trial < 6; trial += STEP) {
        make_arm(trial % 2);
        make_data(special, 14, 0);
        off_nominal();
        for (int k = 0; k < ELEMENTS; k++) {
            double *rpy = theta + 6 * k + 3;
            rpy[1] = k % 2 ? M_PI_2 : -M_PI_2;                /* gimbal lock */
            if (trial > 1) rpy[0] = special[(k + trial) % 4]; /* and the awkward angles */
            if (trial > 3) rpy[2] = special[(k + 2 * trial) % 4], rpy[1] = special[k % 4];
        }
        check_point(&(mukca_selection){0}, (mukca_cost_options){0});
        mukca_dataset_free(&data);
    }
}

TEST(test_poses_and_frames)
{
    seeded = mukca_random_seeded(4);
    for (int trial = 0; trial < 4; trial += STEP) {
        make_arm(trial % 2);
        if (trial > 1) chain.n_elements--; /* the last joint turns: the tool gets a frame */
        const int before = chain.n_elements;
        assert_ok(mukca_chain_with_frames(&chain, &chain, true, true, &error));
        assert_int_equal(chain.n_elements, before + 1 + (trial > 1));
        make_data(NULL, trial ? 9 : 5, 13);
        off_nominal();
        check_point(&(mukca_selection){0}, (mukca_cost_options){0});
        mukca_dataset_free(&data);
    }
}

/* Derivatives of the tip's position, then orientation. */
static const double *tip_jacobian(mukca_pool *pool, const double *q, int rows)
{
    mukca_sweep sweep;
    mukca_parameters parameters;
    assert_ok(mukca_parameters_select(&parameters, &chain, &(mukca_selection){0}, NULL));
    const size_t one = 3 * (size_t)(rows * parameters.n);
    double *J = MUKCA_TAKE(pool, double, 2 * one);
    mukca_sweep_take(&sweep, pool, &chain, rows);
    assert_false(pool->failed);
    mukca_sweep_load(&sweep, &chain, q);
    mukca_sweep_origins(&sweep, theta);
    for (int v = 0; v < sweep.n_windows; v++) {
        mukca_sweep_open(&sweep, v);
        mukca_sweep_forward(&sweep);
        double *at = J + 3 * sweep.from * parameters.n;
        mukca_sweep_jacobian(at, at + one, &sweep, theta, &parameters, MUKCA_GRADIENT_ANALYTIC);
    }
    return J;
}

/* Many samples are swept in windows: the same bits as a few alone. */
TEST(test_windows)
{
    enum { MANY = 2 * MUKCA_SWEEP_WINDOW + 77, FEW = 50 };
    mukca_pool pool = {0};
    static double q[MANY * JOINTS];
    seeded = mukca_random_seeded(5);
    make_arm(true);
    off_nominal();
    for (int i = 0; i < MANY * JOINTS; i++) q[i] = 4 * mukca_random_uniform(&seeded) - 2;
    const double *all = tip_jacobian(&pool, q, MANY);
    const int starts[] = {0, MUKCA_SWEEP_WINDOW - FEW / 2, MANY - FEW};
    for (int i = 0; i < 3; i++) {
        const double *few = tip_jacobian(&pool, q + starts[i] * JOINTS, FEW);
        mukca_parameters p;
        mukca_parameters_select(&p, &chain, &(mukca_selection){0}, NULL);
        for (int turned = 0; turned < 2; turned++)
            assert_memory_equal(all + 3 * p.n * (turned * MANY + starts[i]),
                                few + 3 * p.n * turned * FEW, sizeof *few * 3 * FEW * (size_t)p.n);
    }
    mukca_pool_free(&pool);
}

TEST_MAIN(NULL, NULL)
