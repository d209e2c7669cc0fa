/* Closeness in tests: written so that NaN fails. */
#ifndef MUKCA_TESTS_CLOSE_H
#define MUKCA_TESTS_CLOSE_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#define assert_close(a, b, tolerance)                                                         \
    do {                                                                                      \
        double close_a = (a), close_b = (b), close_t = (tolerance);                           \
        if (!(fabs(close_a - close_b) <= close_t)) {                                          \
            print_error("%s = %.17g, expected %.17g +- %g\n", #a, close_a, close_b, close_t); \
            fail();                                                                           \
        }                                                                                     \
    } while (0)

#endif
