/* Numbers from text without the C library and its locale. */
#include "base/number.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Powers of ten that a double represents exactly. */
enum { LARGEST_POWER = 22 };
static const double exact_power[LARGEST_POWER + 1] = {
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* The upper half of the bits of a number (Veltkamp 1968). */
static double upper(double x)
{
    const double shifted = 134217729 * x; /* 2^27 + 1 */
    return shifted - (shifted - x);
}

/* a b minus its rounded value, exactly (Dekker 1971); libraries without the instruction round fma
 * twice. */
static double product_rest(double a, double b)
{
    const double a1 = upper(a), b1 = upper(b), a2 = a - a1, b2 = b - b1;
    return ((a1 * b1 - a * b) + a1 * b2 + a2 * b1) + a2 * b2;
}

/* high + low := (high + low) * 10^exponent, in steps of exact powers. */
static void multiply(double *high, double *low, int exponent)
{
    while (exponent) {
        const int size = exponent < 0 ? -exponent : exponent;
        const int step = size < LARGEST_POWER ? size : LARGEST_POWER;
        const double power = exact_power[step];
        if (exponent < 0) {
            const double quotient = *high / power;
            *low = (*high - quotient * power - product_rest(quotient, power) + *low) / power;
            *high = quotient;
        } else {
            *low = product_rest(*high, power) + *low * power;
            *high *= power;
        }
        exponent += exponent < 0 ? step : -step;
    }
}

/* mantissa * 10^exponent, computed in twice the precision of a double: high + low.  The error
 * before the last rounding is some 2^-103; decimals of 17 digits rarely lie so near to the middle
 * of two doubles, and those in the middle are exact. */
static double scale(uint64_t mantissa, int exponent)
{
    double high = (double)mantissa, low = (double)(int64_t)(mantissa - (uint64_t)high);
    if (exponent >= -LARGEST_POWER && exponent <= LARGEST_POWER) {
        if (mantissa < UINT64_C(1) << 53) /* both are exact, and one rounding is (Clinger 1990) */
            return exponent < 0 ? high / exact_power[-exponent] : high * exact_power[exponent];
        multiply(&high, &low, exponent);
        return high + low;
    }
    const int raised = exponent < 0 ? 256 : -256; /* no step is subnormal, or overflows */
    high = scalbn(high, raised);
    low = scalbn(low, raised);
    multiply(&high, &low, exponent);
    return scalbn(high + low, -raised);
}

/* Read the power of ten after a mantissa, clamped far beyond the range of a double; false: none. */
static bool read_exponent(int *power, const char **at)
{
    const char *c = *at + 1;
    const bool negative = *c == '-';
    if (*c == '-' || *c == '+') c++;
    if (!is_digit(*c)) return false;
    for (*power = 0; is_digit(*c); c++)
        if (*power < 10000) *power = 10 * *power + (*c - '0');
    if (negative) *power = -*power;
    *at = c;
    return true;
}

bool mukca_number_parse(double *value, const char *text)
{
    const uint64_t full = UINT64_C(1000000000000000000); /* 19 digits; 10 times that fits */
    const char *c = text;
    uint64_t mantissa = 0;
    int exponent = 0, power = 0;
    bool digits = false, point = false;
    const bool negative = *c == '-';
    if (*c == '-' || *c == '+') c++;
    for (; is_digit(*c) || (*c == '.' && !point); c++) {
        if (*c == '.') {
            point = true;
            continue;
        }
        const bool kept = mantissa < full; /* the digits beyond 19 are cut */
        if (kept) mantissa = 10 * mantissa + (uint64_t)(*c - '0');
        exponent += !kept - point;
        digits = true;
    }
    if (!digits || ((*c == 'e' || *c == 'E') && !read_exponent(&power, &c)) || *c) return false;
    const double size = mantissa ? scale(mantissa, exponent + power) : 0;
    *value = negative ? -size : size;
    return isfinite(size);
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
