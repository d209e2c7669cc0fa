/* Inverse kinematics: every pose that an arm can take is found again, limits hold, effects count.
 */
#include "arm/inverse.h"
#include "close.h"
#include "gen3.h"
#include "math/random.h"

static mukca_chain chain;
static mukca_geometry geometry;

/* The Gen3 with limits of 2.5 rad. */
FIXTURE(setup)
{
    gen3_chain(&chain);
    for (int k = 0; k < 7; k++) chain.element[k].lower = -2.5, chain.element[k].upper = 2.5;
    mukca_geometry_set(&geometry, &chain, NULL);
    return 0;
}

TEST(test_positions_and_poses)
{
    mukca_random random = mukca_random_seeded(11);
    int positions = 0, poses = 0;
    for (int i = 0; i < 200; i++) {
        const bool pose = i % 2;
        double truth[7], q[7], off = 0;
        mukca_frame target, reached;
        for (int j = 0; j < 7; j++) {
            truth[j] = 2.3 * (2 * mukca_random_uniform(&random) - 1);
            q[j] = fmax(-2.5, fmin(2.5, truth[j] + 0.3 * mukca_random_normal(&random)));
        }
        mukca_fk_pose(&target, &geometry, truth, NULL);
        mukca_inverse_result r =
            mukca_inverse_solve(q, &chain, &geometry, &target, pose, &(mukca_inverse_options){0});
        mukca_fk_pose(&reached, &geometry, q, NULL);
        for (int k = 0; k < 3; k++) off += pow(reached.p[k] - target.p[k], 2);
        for (int k = 0; k < 9 && pose; k++) off += pow(reached.R[k] - target.R[k], 2);
        for (int j = 0; j < 7; j++) assert_true(q[j] >= -2.5 && q[j] <= 2.5);
        /* what it says is what forward kinematics finds */
        if (r.reached) assert_true(sqrt(off) <= 1e-8);
        if (!r.reached) assert_true(sqrt(off) > 1e-9);
        if (pose)
            poses += r.reached;
        else
            positions += r.reached;
    }
    assert_in_range(positions, 99, 100);
    assert_in_range(poses, 90, 100);
}

TEST(test_out_of_reach)
{
    const mukca_frame target = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {3, 0, 0.3}};
    double q[7] = {0.1, 0.5, 0.1, -1, 0.1, 1, 0.1};
    mukca_inverse_result r =
        mukca_inverse_solve(q, &chain, &geometry, &target, false, &(mukca_inverse_options){0});
    assert_false(r.reached);
    /* stretched towards it: 3 m less a reach below 1 m */
    assert_true(r.position_error > 2.0 && r.position_error < 2.2);
}

static void sag(mukca_displacement *displacement, const double *q, void *context)
{
    displacement->q[1] += *(double *)context * sin(q[1]);
}

TEST(test_effects)
{
    double q[7] = {0.4, 0.6, -0.3, -1.4, 0.2, 1.2, 0.5}, factor = 2e-3, position[3];
    mukca_frame target;
    mukca_fk_pose(&target, &geometry, q, NULL);
    mukca_inverse_options options = {.displace = sag, .context = &factor};
    assert_true(mukca_inverse_solve(q, &chain, &geometry, &target, true, &options).reached);
    q[1] += factor * sin(q[1]);
    mukca_fk_position(position, &geometry, q, NULL);
    for (int k = 0; k < 3; k++) assert_close(position[k], target.p[k], 2e-9);
}

TEST_MAIN(setup, NULL)
