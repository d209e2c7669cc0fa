/* Numbers from text. */
#include "base/number.h"

#include <math.h>
#include <stdint.h>
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
    /* Both factors exact: one rounding, the right one (Clinger).  Else the C library's way. */
    if (exact && mantissa <= (UINT64_C(1) << 53) && exponent >= -22 && exponent <= 22) {
        double m = (double)mantissa;
        m = exponent < 0 ? m / exact_power[-exponent] : m * exact_power[exponent];
        *value = negative ? -m : m;
        return true;
    }
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
