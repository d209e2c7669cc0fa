/* Numbers from text and as text. */
#include "base/number.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Powers of ten that are exact. */
static const double exact_power[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                     1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                     1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

#ifdef __SIZEOF_INT128__
__extension__ typedef unsigned __int128 wide;

/* m / 10^k rounded to nearest even, for m > 0 and k of 0 .. 19: by long division. */
static double divide(uint64_t m, int k)
{
    uint64_t power = 1, left;
    for (int i = 0; i < k; i++) power *= 10;
    const int lead = __builtin_clzll(m);
    const wide numerator = (wide)(m << lead) << 63; /* m 2^(lead + 63) */
    const wide quotient = numerator / power;        /* 62 bits at least */
    const bool rest = quotient * power != numerator;
    const uint64_t high = (uint64_t)(quotient >> 64);
    const int bits = high ? 128 - __builtin_clzll(high) : 64 - __builtin_clzll((uint64_t)quotient);
    const int drop = bits - 53;
    left = (uint64_t)(quotient >> drop);
    const wide cut = quotient & (((wide)1 << drop) - 1), half = (wide)1 << (drop - 1);
    if (cut > half || (cut == half && (rest || (left & 1)))) left++;
    return ldexp((double)left, drop - lead - 63);
}
#endif

bool mukca_number_parse(double *value, const char *text)
{
    const char *c = text;
    uint64_t mantissa = 0;
    int digits = 0, exponent = 0;
    bool negative = *c == '-', exact = true;
    if (*c == '-' || *c == '+') c++;
    const char *first = c;
    for (bool point = false; is_digit(*c) || (*c == '.' && !point); c++) {
        if (*c == '.') {
            point = true;
            continue;
        }
        if (mantissa > (UINT64_MAX - 9) / 10) exact = false;
        if (exact) mantissa = 10 * mantissa + (uint64_t)(*c - '0');
        exponent -= point;
        digits++;
    }
    if (!digits || c == first) return false;
    if (*c == 'e' || *c == 'E') {
        c++;
        bool down = *c == '-';
        if (*c == '-' || *c == '+') c++;
        if (!is_digit(*c)) return false;
        int power = 0;
        for (; is_digit(*c); c++)
            if (power < 10000) power = 10 * power + (*c - '0');
        exponent += down ? -power : power;
    }
    if (*c) return false;
    /* Both factors exact: one rounding, the right one (Clinger). */
    if (exact && mantissa <= (UINT64_C(1) << 53) && exponent >= -22 && exponent <= 22) {
        double m = (double)mantissa;
        m = exponent < 0 ? m / exact_power[-exponent] : m * exact_power[exponent];
        *value = negative ? -m : m;
        return true;
    }
#ifdef __SIZEOF_INT128__
    if (exact && mantissa > 0 && exponent <= 0 && exponent >= -19) { /* %.17g */
        const double m = divide(mantissa, -exponent);
        *value = negative ? -m : m;
        return true;
    }
#endif
    *value = strtod(text, NULL);
    return isfinite(*value);
}

bool mukca_number_parse_list(double *values, int n, const char *text)
{
    for (int i = 0; i < n; i++) {
        char word[64];
        text += strspn(text, " \t\r\n");
        size_t length = strcspn(text, " \t\r\n");
        if (length == 0 || length >= sizeof word) return false;
        memcpy(word, text, length);
        word[length] = '\0';
        if (!mukca_number_parse(&values[i], word)) return false;
        text += length;
    }
    return text[strspn(text, " \t\r\n")] == '\0';
}

void mukca_number_format(char text[MUKCA_NUMBER_SIZE], double value)
{
    for (int digits = 15; digits <= 17; digits++) {
        double back;
        snprintf(text, MUKCA_NUMBER_SIZE, "%.*g", digits, value + 0.0); /* -0 + 0 is 0 */
        if (mukca_number_parse(&back, text) && !(back < value) && !(back > value)) return;
    }
}
