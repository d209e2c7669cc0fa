/* Sine and cosine of arrays: within 1 ulp of 113 bits, zeros, infinities and NaN as the C library,
 * and the same bits wherever an angle stands. */
#define MUKCA_SCALAR /* the kernel of controllers here, that of this machine in the library */
#include "math/sincos.h"

#include "close.h"
#include "math/random.h"
#include "math/sincos_lanes.h"

enum { N = 1024, ROUNDS = 400 };

/* Sine and cosine with more bits than a double has, by another way than the kernel's: the angle is
 * reduced with 2 pi of 200 bits, then the series; __float128 where there is one.  Else the test
 * compares with long double, whose pi of 64 bits the C library handles. */
#if defined(__SIZEOF_FLOAT128__)
__extension__ typedef __float128 precise;

static void reference(precise *s, precise *c, double x)
{
    /* pi/2 in parts of 53 bits (their hexadecimal digits are those of pi in OEIS A062964): n times
     * one has at most 74 bits, exact in 113; the sum keeps 113 bits of what is left. */
    static const double part[] = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54,
                                  -0x1.f1976b7ed8fbcp-110, 0x1.4cf98e804177dp-164};
    const double n = nearbyint(x / 1.5707963267948966);
    precise r = x, sum_s = 0, sum_c = 0, term = 1;
    for (int i = 0; i < 4; i++) r -= (precise)n * part[i];
    for (int i = 0; i < 40; i++) { /* term = r^i / i! with the series' sign */
        if (i % 2)
            sum_s += i % 4 == 1 ? term : -term;
        else
            sum_c += i % 4 == 0 ? term : -term;
        term *= r / (i + 1);
    }
    const int quadrant = (int)((long)n & 3);
    *s = quadrant & 1 ? sum_c : sum_s;
    *c = quadrant & 1 ? sum_s : sum_c;
    if (quadrant & 2) *s = -*s;
    if ((quadrant + 1) & 2) *c = -*c;
}
#else
typedef long double precise;

static void reference(precise *s, precise *c, double x)
{
    *s = sinl(x), *c = cosl(x);
}
#endif

/* |got - want| in units of the last place of want. */
static double ulps(double got, precise want)
{
    int exponent;
    frexp((double)want, &exponent);
    const double unit = ldexp(1, exponent - 53 < -1074 ? -1074 : exponent - 53);
    return fabs((double)(((precise)got - want) / unit));
}

/* An angle of one of several kinds. */
static double angle(mukca_random *random, int kind)
{
    const double u = 2 * mukca_random_uniform(random) - 1;
    switch (kind % 5) {
        case 0:
            return 4 * u;
        case 1:
            return MUKCA_SINCOS_LARGEST * u;
        case 2:
            return ldexp(u, -mukca_random_below(random, 60));
        case 3: { /* next to a multiple of pi/2: the doubles about it */
            double x = nearbyint(667000 * u) * 1.5707963267948966;
            for (int step = mukca_random_below(random, 4); step > 0; step--) x = nextafter(x, 0);
            return x;
        }
        default:
            return 0.8 * u;
    }
}

TEST(within_one_ulp)
{
    static double x[N], s[N], c[N];
    mukca_random random = mukca_random_seeded(3);
    for (int round = 0; round < ROUNDS; round++) {
        for (int i = 0; i < N; i++) x[i] = angle(&random, round);
        mukca_sincos(s, c, x, N);
        for (int i = 0; i < N; i++) {
            precise sine, cosine;
            reference(&sine, &cosine, x[i]);
            const double ulp = fmax(ulps(s[i], sine), ulps(c[i], cosine));
            if (!(ulp <= 1)) fail_msg("%a: %g ulp", x[i], ulp);
        }
    }
}

TEST(edges_as_the_c_library)
{
    const double x[] = {0.0,        -0.0,        0x1p-1074, -0x1p-1074, 0x1.8p-1030,
                        -0x1p-1022, 0x1p-600,    0x1p-28,   -0x1p-28,   INFINITY,
                        -INFINITY,  (double)NAN, 0x1.8p20,  -1e22,      0x1p1023};
    enum { EDGES = sizeof x / sizeof *x };
    double s[EDGES + 3], c[EDGES + 3];
    mukca_sincos(s, c, x, EDGES);
    for (int i = 0; i < EDGES; i++) {
        const double sine = sin(x[i]), cosine = cos(x[i]);
        if (isnan(sine))
            assert_true(isnan(s[i]) && isnan(c[i]));
        else
            assert_true(memcmp(&s[i], &sine, sizeof sine) == 0 && c[i] == cosine);
    }
}

TEST(one_lane_gives_the_same_bits)
{
    mukca_random random = mukca_random_seeded(11);
    for (int trial = 0; trial < 20000; trial++) {
        const double x = angle(&random, trial);
        double s[4], c[4], sine, cosine;
        lane_bits wide = 0;
        mukca_sincos(s, c, &x, 1);
        sincos_lanes(&sine, &cosine, &wide, &x);
        assert_true(wide == 0);
        assert_memory_equal(s, &sine, sizeof sine);
        assert_memory_equal(c, &cosine, sizeof cosine);
    }
    const double beyond[] = {0x1.0000000000001p20, -0x1p21, INFINITY, (double)NAN};
    for (int i = 0; i < 4; i++) {
        double sine, cosine;
        lane_bits wide = 0;
        sincos_lanes(&sine, &cosine, &wide, &beyond[i]);
        assert_true(wide != 0);
    }
}

TEST(place_and_number_do_not_matter)
{
    enum { MOST = 19 };
    mukca_random random = mukca_random_seeded(5);
    for (int trial = 0; trial < 2000; trial++) {
        double x[MOST], s[MOST + 3], c[MOST + 3], sine[4], cosine[4];
        const int n = 1 + mukca_random_below(&random, MOST);
        for (int i = 0; i < n; i++) x[i] = angle(&random, mukca_random_below(&random, 5));
        if (trial % 3 == 0) x[n / 2] = 1e9;
        mukca_sincos(s, c, x, n);
        for (int i = 0; i < n; i++) {
            mukca_sincos(sine, cosine, &x[i], 1);
            assert_memory_equal(&s[i], sine, sizeof *sine);
            assert_memory_equal(&c[i], cosine, sizeof *cosine);
        }
    }
}

TEST_MAIN(NULL, NULL)
