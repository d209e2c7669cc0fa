/* Numbers from text, correctly rounded, without the C library and its locale. */
#include "base/number.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Powers of ten that a double represents exactly. */
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
    const uint64_t power = (uint64_t)exact_power[k];
    uint64_t left;
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
    return scalbn((double)left, drop - lead - 63);
}
#endif

/* Significant digits: the midpoint of two doubles has at most 768.  All further digits, if not
 * zero, are replaced by a single 1. */
enum { MOST_DIGITS = 770, MOST_LIMBS = 120 };

/* Natural number below 2^(32 * MOST_LIMBS): 10^1115, the largest divisor, has 3704 bits. */
typedef struct {
    int n; /* limbs in use; limb[n - 1] is not 0 */
    uint32_t limb[MOST_LIMBS];
} big;

/* a := a * factor + summand */
static void multiply_add(big *a, uint32_t factor, uint32_t summand)
{
    uint64_t carry = summand;
    for (int i = 0; i < a->n; i++) {
        carry += (uint64_t)a->limb[i] * factor;
        a->limb[i] = (uint32_t)carry;
        carry >>= 32;
    }
    if (carry) a->limb[a->n++] = (uint32_t)carry;
}

static void multiply_power(big *a, int exponent)
{
    for (; exponent >= 9; exponent -= 9) multiply_add(a, 1000000000U, 0);
    for (; exponent > 0; exponent--) multiply_add(a, 10, 0);
}

static int bits(const big *a)
{
    return 32 * a->n - __builtin_clz(a->limb[a->n - 1]);
}

static void shift(big *a, int left)
{
    for (; left >= 31; left -= 31) multiply_add(a, UINT32_C(1) << 31, 0);
    if (left > 0) multiply_add(a, UINT32_C(1) << left, 0);
}

static bool is_less(const big *a, const big *b)
{
    if (a->n != b->n) return a->n < b->n;
    for (int i = a->n - 1; i >= 0; i--)
        if (a->limb[i] != b->limb[i]) return a->limb[i] < b->limb[i];
    return false;
}

/* a := a - b, for a >= b */
static void subtract(big *a, const big *b)
{
    int64_t borrow = 0;
    for (int i = 0; i < a->n; i++) {
        borrow += (int64_t)a->limb[i] - (i < b->n ? (int64_t)b->limb[i] : 0);
        a->limb[i] = (uint32_t)borrow;
        borrow >>= 32;
    }
    while (a->n > 0 && a->limb[a->n - 1] == 0) a->n--;
}

/* a / b rounded to nearest even, for b > 0: 64 bits of the quotient by long division. */
static double quotient(big *a, big *b)
{
    if (a->n == 0) return 0;
    int top = bits(a) - bits(b); /* the quotient is at least 2^(top - 1) */
    shift(b, top);
    shift(a, -top);
    if (is_less(a, b)) {
        shift(a, 1);
        top--;
    }
    uint64_t mantissa = 0;
    for (int i = 0; i < 64; i++) {
        const bool one = !is_less(a, b);
        if (one) subtract(a, b);
        mantissa = mantissa << 1 | one;
        shift(a, 1);
    }
    const int kept = top < -1022 ? 53 + 1022 + top : 53; /* fewer if subnormal */
    if (kept < 0) return 0;
    const int drop = 64 - kept;
    const uint64_t half = UINT64_C(1) << (drop - 1);
    uint64_t left = kept > 0 ? mantissa >> drop : 0;
    const uint64_t cut = kept > 0 ? mantissa & (2 * half - 1) : mantissa;
    if (cut > half || (cut == half && (a->n > 0 || (left & 1)))) left++;
    return scalbn((double)left, top - 63 + drop);
}

/* The decimal digits at `text` (with or without point) times 10^exponent; infinite if too large. */
static double divide_digits(const char *text, int exponent)
{
    big a = {.n = 0}, b = {.n = 1, .limb = {1}};
    int digits = 0;
    bool rest = false;
    for (; is_digit(*text) || *text == '.'; text++) {
        if (*text == '.' || (digits == 0 && *text == '0')) continue;
        if (++digits <= MOST_DIGITS)
            multiply_add(&a, 10, (uint32_t)(*text - '0'));
        else
            rest = rest || *text != '0';
    }
    if (digits > MOST_DIGITS) exponent += digits - MOST_DIGITS, digits = MOST_DIGITS;
    if (digits + exponent > 310) return digits ? HUGE_VAL : 0; /* 10^309 is too large */
    if (digits + exponent < -330) return 0;                    /* 10^-324 is too small */
    if (rest) {
        multiply_add(&a, 10, 1);
        exponent--;
    }
    multiply_power(exponent > 0 ? &a : &b, exponent > 0 ? exponent : -exponent);
    return quotient(&a, &b);
}

bool mukca_number_parse(double *value, const char *text)
{
    const char *c = text;
    uint64_t mantissa = 0; /* meaningless beyond 19 digits */
    int exponent = 0;
    const bool negative = *c == '-';
    if (*c == '-' || *c == '+') c++;
    const char *first = c;
    for (; is_digit(*c); c++) mantissa = 10 * mantissa + (uint64_t)(*c - '0');
    ptrdiff_t digits = c - first;
    if (*c == '.') {
        const char *fraction = ++c;
        for (; is_digit(*c); c++) mantissa = 10 * mantissa + (uint64_t)(*c - '0');
        digits += c - fraction;
        exponent = (int)(fraction - c);
    }
    if (digits == 0) return false;
    const bool exact = digits <= 19; /* 10^19 < 2^64 */
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
    /* Both factors exact: a single, correct rounding (Clinger). */
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
    const double size = divide_digits(first, exponent);
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
