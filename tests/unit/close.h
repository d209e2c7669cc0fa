/* Tests, and closeness in them. */
#ifndef MUKCA_TESTS_CLOSE_H
#define MUKCA_TESTS_CLOSE_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

/* TEST(what_it_shows) { ... }; TEST_MAIN(setup, teardown) runs those of the file in their order. */
#define TEST(name)                                                           \
    static void name(void **state);                                          \
    __attribute__((constructor)) static void name##_is_a_test(void)          \
    {                                                                        \
        test_list[test_count++] = (struct CMUnitTest)cmocka_unit_test(name); \
    }                                                                        \
    static void name(void **state __attribute__((unused)))
#define TEST_MAIN(setup, teardown)        \
    int main(void)                        \
    {                                     \
        return test_run(setup, teardown); \
    }

static struct CMUnitTest test_list[64];
static size_t test_count;

static inline int test_run(CMFixtureFunction setup, CMFixtureFunction teardown)
{
    return _cmocka_run_group_tests("tests", test_list, test_count, setup, teardown);
}

/* Written so that NaN fails. */
#define assert_close(a, b, tolerance)                                                         \
    do {                                                                                      \
        double close_a = (a), close_b = (b), close_t = (tolerance);                           \
        if (!(fabs(close_a - close_b) <= close_t)) {                                          \
            print_error("%s = %.17g, expected %.17g +- %g\n", #a, close_a, close_b, close_t); \
            fail();                                                                           \
        }                                                                                     \
    } while (0)

#endif
