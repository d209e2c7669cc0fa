/* Two models compared: what is gauge is no difference, and what is built in is found. */
#include "arm/compare.h"

#include "close.h"
#include "gen3.h"
#include "math/random.h"

static mukca_comparison comparison; /* large */
static mukca_corrected a, b;

/* The paper's arm, twice. */
FIXTURE(setup)
{
    memset(&a, 0, sizeof a);
    gen3_chain(&a.chain);
    mukca_geometry_set(&a.geometry, &a.chain, NULL);
    b = a;
    return 0;
}

static void move(mukca_frame *T, const double turn[3], const double shift[3], bool before)
{
    mukca_frame step;
    mukca_rotation_exp(step.R, turn);
    memcpy(step.p, shift, sizeof step.p);
    mukca_frame_multiply(T, before ? &step : T, before ? T : &step);
}

/* Move the frame of each joint along and about its axis, and undo it in the next link. */
static void change_gauge(mukca_corrected *arm)
{
    static const double base_turn[3] = {0.3, -2.8, 0.4}, base_shift[3] = {0.5, -0.2, 0.9};
    static const double tool_turn[3] = {0, 1, 0}, tool_shift[3] = {0.02, -0.03, 0.05};
    mukca_random random = mukca_random_seeded(4);
    for (int k = 0; k < 7; k++) {
        const double angle = 6 * mukca_random_uniform(&random) - 3;
        const double along = 0.4 * mukca_random_uniform(&random) - 0.2;
        const double turn[3] = {0, 0, angle}, shift[3] = {0, 0, along};
        const double unturn[3] = {0, 0, -angle}, unshift[3] = {0, 0, -along};
        move(&arm->geometry.origin[k], turn, shift, false);
        move(&arm->geometry.origin[k + 1], unturn, unshift, true);
    }
    move(&arm->geometry.origin[0], base_turn, base_shift, true);
    move(&arm->geometry.origin[7], tool_turn, tool_shift, false);
}

TEST(gauge_is_no_difference)
{
    change_gauge(&b);
    mukca_compare(&comparison, &a, &b);
    for (int j = 0; j < 7; j++) {
        const mukca_axis_difference *d = &comparison.axis[j];
        assert_close(d->angle, 0, 1e-7);
        assert_close(d->distance, 0, 1e-9);
        assert_true(isnan(d->zero) == (j == 0 || j == 6));
        if (j > 0 && j < 6) assert_close(d->zero, 0, 1e-9);
        if (j > 0 && j < 6) assert_close(d->slide, 0, 1e-9);
    }
    assert_true(comparison.position[0].mean > 0.5);
    assert_close(comparison.position[1].max, 0, 1e-9);
    assert_close(comparison.rotation[1].max, 0, 1e-7);
}

/* One change of a joint at a time, seen in any gauge. */
TEST(differences_are_those_built_in)
{
    static const struct {
        int element;
        double turn[3], shift[3]; /* of the joint's frame, about and along its own axes */
        int joint;                /* where it shows, */
        double angle, distance, zero, slide;
    } changes[] = {
        {3, {0, 0, 2e-3}, {0, 0, 0}, 3, 0, 0, 2e-3, 0},          /* zero of joint 4 */
        {3, {1.5e-3, 0, 0}, {0, 0, 0}, 3, 1.5e-3, 0, NAN, 0},    /* tilt of its axis ... */
        {4, {0, 0, 0}, {7e-4, 0, 0}, 4, 0, 7e-4, 0, 0},          /* shift of axis 5 ... */
        {0, {3e-3, 0, 1e-3}, {2e-3, 0, 1e-3}, 0, 0, 0, NAN, NAN} /* the base is gauge */
    };
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
        setup(NULL);
        const int k = changes[i].element, at = changes[i].joint;
        move(&b.geometry.origin[k], changes[i].turn, changes[i].shift, false);
        change_gauge(&b);
        mukca_compare(&comparison, &a, &b);
        const mukca_axis_difference *d = &comparison.axis[at];
        assert_close(d->angle, changes[i].angle, 1e-7);
        assert_close(d->distance, changes[i].distance, 1e-8);
        if (isfinite(changes[i].zero)) assert_close(d->zero, changes[i].zero, 1e-6);
        if (isfinite(changes[i].slide)) assert_close(d->slide, changes[i].slide, 1e-6);
        for (int j = 0; j < at; j++) { /* nothing before it */
            assert_close(comparison.axis[j].angle, 0, 1e-7);
            assert_close(comparison.axis[j].distance, 0, 1e-8);
        }
        if (k > 0)
            assert_true(comparison.position[1].mean > 1e-5);
        else
            assert_close(comparison.position[1].max, 0, 1e-9);
    }
}

/* Between parallel axes nothing shows a shift along them; none is invented. */
TEST(parallel_axes)
{
    static const double straight[3] = {0, 0, 0};
    memcpy(a.chain.element[3].rpy, straight, sizeof straight);
    mukca_geometry_set(&a.geometry, &a.chain, NULL);
    b = a;
    static const double tilt[3] = {0, 1e-3, 0}, shift[3] = {3e-4, 0, 5e-4};
    move(&b.geometry.origin[3], tilt, shift, false);
    mukca_compare(&comparison, &a, &b);
    assert_true(isnan(comparison.axis[2].slide));
    assert_close(comparison.axis[3].angle, 1e-3, 1e-5);
    assert_true(comparison.axis[3].distance < 1e-3);
}

/* The alignment is the best: no small move of base or tool makes the squares less. */
TEST(alignment_is_least_squares)
{
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < 3; i++) b.geometry.origin[k].p[i] += gen3_dp[k][i];
    mukca_compare(&comparison, &a, &b);
    double squares[19] = {0};
    for (int m = 0; m < 19; m++) {
        mukca_frame base = comparison.base, tool = comparison.tool;
        const int i = (m - 1) / 2;
        const double h = m == 0 ? 0 : m % 2 ? 1e-4 : -1e-4;
        double x[9] = {0}; /* turn and shift of the base, shift of the tool */
        if (m > 0) x[i] = h;
        static const double none[3] = {0, 0, 0};
        move(&base, x, x + 3, true);
        move(&tool, none, x + 6, true);
        for (int n = 0; n < MUKCA_COMPARED; n++) {
            mukca_frame T;
            mukca_frame_multiply(&T, &base, &comparison.tip[1][n]);
            mukca_frame_multiply(&T, &T, &tool);
            const double d = mukca_distance3(T.p, comparison.tip[0][n].p);
            squares[m] += d * d;
        }
        if (m) assert_true(squares[m] > squares[0]);
    }
    assert_true(comparison.position[1].mean < comparison.position[0].mean);
    assert_true(comparison.position[1].p95 <= comparison.position[1].max);
}

TEST_EACH(setup, NULL)
