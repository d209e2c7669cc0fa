/* Tests, and what they assert: closeness, success, one clear line of error; with the C library. */
#ifndef MUKCA_TESTS_CLOSE_H
#define MUKCA_TESTS_CLOSE_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "mukca/status.h"

static mukca_error error __attribute__((unused)); /* of the last call */
static char notes[2048] __attribute__((unused));

/* Collect notes, a line each. */
static inline void note(void *context, const char *text)
{
    (void)context;
    strncat(notes, text, sizeof notes - strlen(notes) - 2);
    strcat(notes, "\n");
}

/* Memory for n items, and a copy of exact size, so that a sanitizer sees a read behind its end. */
static inline void *zeroed(size_t n, size_t size)
{
    void *memory = calloc(n, size);
    assert_non_null(memory);
    return memory;
}

static inline unsigned char *copied(const void *bytes, size_t n)
{
    return memcpy(zeroed(n ? n : 1, 1), bytes, n);
}

/* What is wrong, and a part of what is said of it. */
typedef struct {
    const char *text, *part;
} bad_text;

/* TEST(what_it_shows) { ... }; TEST_MAIN(setup, teardown) runs those of the file in their order;
 * TEST_EACH does both about each of them.  FIXTURE(setup) { ...; return 0; } */
#define FIXTURE(name) static inline int name(void **state __attribute__((unused)))
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

#define TEST_EACH(setup, teardown)                                                  \
    int main(void)                                                                  \
    {                                                                               \
        for (size_t i = 0; i < test_count; i++)                                     \
            test_list[i].setup_func = setup, test_list[i].teardown_func = teardown; \
        return test_run(NULL, NULL);                                                \
    }

static struct CMUnitTest test_list[64];
static size_t test_count;

static inline int test_run(CMFixtureFunction setup, CMFixtureFunction teardown)
{
    return _cmocka_run_group_tests("tests", test_list, test_count, setup, teardown);
}

/* Written so that NaN fails. */
#define assert_close(a, b, tolerance)                                                    \
    do {                                                                                 \
        double close_a = (a), close_b = (b), close_t = (tolerance);                      \
        if (!(fabs(close_a - close_b) <= close_t))                                       \
            fail_msg("%s = %.17g, expected %.17g +- %g", #a, close_a, close_b, close_t); \
    } while (0)

#define assert_frame(a, b, tolerance)                                                   \
    do {                                                                                \
        for (int i_ = 0; i_ < 3; i_++) assert_close((a)->p[i_], (b)->p[i_], tolerance); \
        for (int i_ = 0; i_ < 9; i_++) assert_close((a)->R[i_], (b)->R[i_], tolerance); \
    } while (0)

#define assert_ok(call)                                                \
    do {                                                               \
        if ((call) != MUKCA_OK) fail_msg("%s: %s", #call, error.text); \
    } while (0)

/* An error of that status whose text holds `part` and is one line. */
#define assert_error(status, wanted, error, part)                        \
    do {                                                                 \
        assert_int_equal((status), (wanted));                            \
        if (!strstr((error).text, (part)) || strchr((error).text, '\n')) \
            fail_msg("'%s' lacks '%s'", (error).text, (part));           \
    } while (0)
#define assert_refused(call, part) assert_error(call, MUKCA_INPUT, error, part)

#define assert_part(text, part)                                          \
    do {                                                                 \
        const char *whole = (text);                                      \
        if (!whole || !strstr(whole, (part)))                            \
            fail_msg("'%s' lacks '%s'", whole ? whole : "NULL", (part)); \
    } while (0)

#endif
