/* Base to base: the pose that was built in, and intervals that hold it as often as they say. */
#include "fit/align.h"

#include "close.h"
#include "math/random.h"

enum { SOCKETS = 6 };

static const mukca_frame truth = {.R = {0, -1, 0, 1, 0, 0, 0, 0, 1}, .p = {1.2, -0.3, 0.05}};

static mukca_shared_socket s[SOCKETS];
static mukca_two_arms t;
static mukca_random seeded;

/* Two sockets in each of three placements, seen with `noise` m per axis (std of the means). */
static void make(double noise, double stated)
{
    static const double places[3][3] = {{0.4, 0.1, 0.1}, {0.5, -0.2, 0.3}, {0.3, 0, 0.5}};
    for (int i = 0; i < SOCKETS; i++) {
        const double at[3] = {places[i / 2][0] + 0.05 * (i % 2), places[i / 2][1],
                              places[i / 2][2]};
        mukca_mat3_vec(s[i].at[0], truth.R, at);
        for (int a = 0; a < 3; a++) {
            s[i].at[0][a] += truth.p[a] + noise * mukca_random_normal(&seeded);
            s[i].at[1][a] = at[a] + noise * mukca_random_normal(&seeded);
        }
        s[i].variance[0] = s[i].variance[1] = stated * stated;
    }
}

TEST(exact_sockets_give_the_pose)
{
    seeded = mukca_random_seeded(1);
    make(0, 1e-4);
    assert_ok(mukca_two_arms_align(&t, s, SOCKETS, NULL));
    assert_frame(&t.pose, &truth, 1e-12);
    assert_close(t.residual_m, 0, 1e-12);
    assert_close(t.scale, 1, 0);
}

/* 2000 runs of six numbers: 95 % within 4 standard errors of a share (they are correlated). */
TEST(intervals_hold)
{
    static const double stated[2] = {1e-4, 1e-5}; /* noise as stated; understated tenfold */
    for (int k = 0; k < 2; k++) {
        int inside = 0;
        enum { RUNS = 2000 };
        seeded = mukca_random_seeded(7);
        for (int run = 0; run < RUNS; run++) {
            double w[3];
            make(1e-4, stated[k]);
            assert_ok(mukca_two_arms_align(&t, s, SOCKETS, NULL));
            mukca_rotation_difference(w, t.pose.R, truth.R);
            for (int a = 0; a < 3; a++) {
                inside += fabs(t.pose.p[a] - truth.p[a]) <= t.width95[a];
                inside += fabs(w[a]) <= t.width95[3 + a];
            }
        }
        const double share = inside / (6.0 * RUNS);
        assert_close(share, 0.96, 0.025); /* scale >= 1 errs on the safe side */
    }
}

TEST(sockets_that_do_not_suffice)
{
    seeded = mukca_random_seeded(1);
    make(1e-5, 1e-5);
    for (int i = 0; i < SOCKETS; i++)
        for (int k = 0; k < 2; k++)
            for (int a = 0; a < 3; a++) s[i].at[k][a] = a == k ? 0.1 * i : 0.2;
    assert_error(mukca_two_arms_align(&t, s, SOCKETS, &error), MUKCA_UNIDENTIFIABLE, error,
                 "one line");
}

TEST_MAIN(NULL, NULL)
