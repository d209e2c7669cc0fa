/* Numbers from text: the same bits as the C library's, and nothing else taken for one. */
#include "base/number.h"

#include "base/suggest.h"
#include "close.h"
#include "math/random.h"

static void check_same(const char *text)
{
    double ours = 1, theirs = strtod(text, NULL);
    assert_true(mukca_number_parse(&ours, text));
    if (memcmp(&ours, &theirs, sizeof ours) != 0) fail_msg("%s: %a, not %a", text, ours, theirs);
}

TEST(numbers_are_the_c_librarys)
{
    char texts[] =
        "0 -0 +1 1. .5 -1.5e-3 1e22 1e23 1e-22 9007199254740993 18446744073709551615 "
        "18446744073709551616 123456789012345678901234567890 4.9e-324 2.2250738585072014e-308 "
        "1e308 1e-400 0e99999 007 1E+5";
    for (char *word = strtok(texts, " "); word; word = strtok(NULL, " ")) check_same(word);
    mukca_random random = mukca_random_seeded(7);
    static const int digits[] = {17, 18, 9, 6, 3, 15};
    for (int i = 0; i < 60000; i++) {
        char text[64];
        double scale = pow(10, mukca_random_below(&random, 40) - 20);
        double value = scale * mukca_random_normal(&random);
        if (i % 2)
            snprintf(text, sizeof text, "%.*g", digits[i % 6], value);
        else
            snprintf(text, sizeof text, "%.*f", digits[i % 6], value);
        check_same(text);
    }
}

/* The middle between two doubles, in all of its digits. */
TEST(ties_are_rounded_to_even)
{
    mukca_random random = mukca_random_seeded(8);
    for (int i = 0; i < 9000; i++) {
        char text[64];
        const double low = floor(ldexp(1 + mukca_random_uniform(&random), 52));
        snprintf(text, sizeof text, "%.3Lf", ldexpl((long double)low + 0.5L, i % 9 - 2));
        check_same(text);
    }
}

/* Digits beyond 19 are cut: less than a thousandth of the distance between two doubles. */
TEST(long_numbers_are_read_to_the_last_bit_but_one)
{
    mukca_random random = mukca_random_seeded(10);
    for (int i = 0; i < 2000; i++) {
        char text[1000];
        double ours = 0;
        const double value = ldexp(0.5 + 0.5 * mukca_random_uniform(&random),
                                   mukca_random_below(&random, 2090) - 1070);
        snprintf(text, sizeof text, "%.780Le", (long double)value);
        assert_true(mukca_number_parse(&ours, text));
        assert_true(ours >= nextafter(value, 0) && ours <= nextafter(value, HUGE_VAL));
    }
}

TEST(printing_without_stdio_agrees)
{
    char ours[96], theirs[96];
    mukca_random random = mukca_random_seeded(9);
    for (int i = 0; i < 20000; i++) {
        const double scale = ldexp(1, mukca_random_below(&random, 80) - 40);
        const double value = i % 2 ? floor(scale) : scale * mukca_random_normal(&random);
        const int number = mukca_random_below(&random, 2001) - 1000;
        mukca_print(ours, sizeof ours, "%d%% %+d '%.10gmNm' %s %.3s %.*s|", number, number, value,
                    "text", "texts", 2, "cut");
        snprintf(theirs, sizeof theirs, "%d%% %+d '%.10gmNm' %s %.3s %.*s|", number, number, value,
                 "text", "texts", 2, "cut");
        assert_string_equal(ours, theirs);
    }
    mukca_print(ours, 6, "%s", "longer than that");
    assert_string_equal(ours, "longe");
    mukca_print(ours, 6, "%d %.2g", -2147483647 - 1, -0.0);
    assert_string_equal(ours, "-2147");
}

TEST(other_texts_are_no_numbers)
{
    static const char *const texts[] = {"",   " 1",  "1 ",    "0x10",   "nan",   "inf", "-inf",
                                        "1e", "1e+", "1,5",   "--1",    "1.2.3", "e5",  ".",
                                        "-",  "1f",  "1e999", "-1e999", "1_000", "１"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        double value;
        if (mukca_number_parse(&value, texts[i]))
            fail_msg("'%s' was taken for %g", texts[i], value);
    }
}

TEST(lists_have_exactly_n)
{
    double v[3];
    assert_true(mukca_number_parse_list(v, 3, " 1\t-2.5\n 3e1 "));
    assert_true(v[0] == 1 && v[1] == -2.5 && v[2] == 30);
    assert_false(mukca_number_parse_list(v, 3, "1 2"));
    assert_false(mukca_number_parse_list(v, 3, "1 2 3 4"));
    assert_false(mukca_number_parse_list(v, 3, "1 2 x"));
    assert_false(mukca_number_parse_list(v, 3, ""));
}

TEST(numbers_are_written_short_and_read_back)
{
    static const struct {
        double value;
        const char *text;
    } known[] = {{0.1, "0.1"},
                 {1.0 / 3, "0.3333333333333333"},
                 {0.1 + 0.2, "0.30000000000000004"},
                 {-0.0, "0"},
                 {1e-300, "1e-300"},
                 {-5, "-5"}};
    char text[MUKCA_NUMBER_SIZE];
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        mukca_number_format(text, known[i].value);
        assert_string_equal(text, known[i].text);
    }
    mukca_random random = mukca_random_seeded(1);
    for (int i = 0; i < 10000; i++) {
        const double value = mukca_random_normal(&random) * exp(10 * mukca_random_normal(&random));
        double back;
        mukca_number_format(text, value);
        assert_true(mukca_number_parse(&back, text) && back == value);
    }
}

TEST(near_names_are_suggested)
{
    assert_int_equal(mukca_suggest_distance("", ""), 0);
    assert_int_equal(mukca_suggest_distance("kitten", "sitting"), 3);
    assert_int_equal(mukca_suggest_distance("clibrate", "calibrate"), 1);
    assert_int_equal(mukca_suggest_distance("calirbate", "calibrate"), 1);
    assert_int_equal(mukca_suggest_distance("Tip", "tip"), 0);
    int best = 99;
    assert_true(mukca_suggest_better(&best, "diagose", "diagnose"));
    assert_false(mukca_suggest_better(&best, "diagose", "report"));
    assert_int_equal(best, 1);
    best = 99;
    assert_false(mukca_suggest_better(&best, "x", "calibrate"));
}

TEST_MAIN(NULL, NULL)
