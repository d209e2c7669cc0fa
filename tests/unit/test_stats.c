/* Statistics and random numbers against published values. */
#include "close.h"
#include "math/random.h"
#include "math/stats.h"

TEST(test_quantiles)
{
    double x[] = {2, 4, 4, 4, 5, 5, 7, 9};
    assert_close(mukca_stats_median(x, 8), 4.5, 0);
    assert_close(mukca_stats_median(x, 0), 0, 0);
    double y[] = {9, 1, 5, 3};
    assert_close(mukca_stats_quantile(y, 4, 0.25), 2.5, 1e-15); /* as numpy.quantile */
    assert_close(mukca_stats_quantile(y, 4, 1), 9, 0);
    double bad[] = {1, NAN, 2};
    assert_true(isnan(mukca_stats_median(bad, 3)));
}

TEST(test_tails)
{
    double x[] = {-1000, -1000}, y[] = {1000, 0, -HUGE_VAL};
    assert_close(mukca_stats_log_sum_exp(x, 2), -1000 + log(2), 1e-12);
    assert_close(mukca_stats_log_sum_exp(y, 3), 1000, 1e-12);
    assert_true(mukca_stats_log_sum_exp(y, 0) == -HUGE_VAL);
    /* scipy.stats.norm.logcdf */
    static const double phi[][2] = {{0, -0.6931471805599453},     {-1, -1.8410216450092636},
                                    {-5, -15.064998393988727},    {-19.9, -201.91716770733265},
                                    {-20.5, -214.06672896326387}, {-40, -804.6084420137539},
                                    {6, -9.86587645524372e-10}};
    for (size_t i = 0; i < sizeof phi / sizeof *phi; i++)
        assert_close(mukca_stats_log_normal_cdf(phi[i][0]), phi[i][1], 1e-13 * fabs(phi[i][1]));
    assert_close(mukca_stats_log_normal_cdf(-19.999999), mukca_stats_log_normal_cdf(-20.000001),
                 1e-4);
}

static double quartic(void *context, double x)
{
    (*(int *)context)++;
    return pow(x - 0.3, 4) + (x - 0.3) * (x - 0.3) - 2;
}

static double slope(void *context, double x)
{
    (void)context;
    return x;
}

TEST(test_minimize)
{
    int calls = 0;
    double value;
    assert_close(mukca_stats_minimize(&value, quartic, &calls, -4, 9, 1e-7), 0.3, 1e-7);
    assert_close(value, -2, 1e-13);
    assert_true(calls < 40);
    assert_close(mukca_stats_minimize(NULL, slope, NULL, 1, 2, 1e-6), 1, 2e-6); /* at the edge */
}

TEST(test_random)
{
    mukca_random random = {.state = {1, 2, 3, 4}}; /* reference output of xoshiro256plusplus.c */
    assert_true(mukca_random_bits(&random) == 41943041u);
    assert_true(mukca_random_bits(&random) == 58720359u);
    assert_true(mukca_random_bits(&random) == 3588806011781223u);
    assert_true(mukca_random_bits(&random) == 3591011842654386u);
    random = mukca_random_seeded(1234567); /* reference output of splitmix64.c */
    assert_true(random.state[0] == 6457827717110365317u);
    assert_true(random.state[1] == 3203168211198807973u);

    enum { N = 200000 };
    double sum = 0, square = 0, fourth = 0;
    int bins[3] = {0};
    for (int i = 0; i < N; i++) {
        double z = mukca_random_normal(&random);
        double u = mukca_random_uniform(&random);
        assert_true(u >= 0 && u < 1);
        sum += z;
        square += z * z;
        fourth += z * z * z * z;
        bins[mukca_random_below(&random, 3)]++;
    }
    assert_close(sum / N, 0, 5 / sqrt(N));
    assert_close(square / N, 1, 5 * sqrt(2.0 / N));
    assert_close(fourth / N, 3, 5 * sqrt(96.0 / N));
    for (int b = 0; b < 3; b++) assert_close(bins[b], N / 3.0, 5 * sqrt(N * 2.0 / 9));
}

TEST_MAIN(NULL, NULL)
