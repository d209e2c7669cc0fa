/* Formatted text without stdio. */
#include "base/number.h"

#include <math.h>
#include <string.h>

typedef struct {
    char *at;
    size_t left; /* without the NUL */
} output;

static void put(output *out, const char *text, size_t length)
{
    if (length > out->left) length = out->left;
    memcpy(out->at, text, length);
    out->at += length;
    out->left -= length;
}

static void put_text(output *out, const char *text, int precision)
{
    size_t length = 0;
    while ((precision < 0 || length < (size_t)precision) && text[length]) length++;
    put(out, text, length);
}

static void put_integer(output *out, long long value, const char *plus)
{
    char digits[24];
    size_t n = sizeof digits;
    unsigned long long left = value < 0 ? 0 - (unsigned long long)value : (unsigned long long)value;
    do digits[--n] = (char)('0' + left % 10);
    while (left /= 10);
    put_text(out, value < 0 ? "-" : plus, -1);
    put(out, digits + n, sizeof digits - n);
}

/* As %.Ng; beyond some 12 digits the last one may differ from the C library's. */
static void put_general(output *out, double value, int precision)
{
    char digits[24] = "";
    if (!isfinite(value)) {
        put_text(out, isnan(value) ? "nan" : value < 0 ? "-inf" : "inf", -1);
        return;
    }
    int exponent = 0;
    double scaled = fabs(value), one = 1;
    for (; scaled >= 10; exponent++) scaled /= 10;
    for (; scaled > 0 && scaled < 1; exponent--) scaled *= 10;
    for (int i = 1; i < precision; i++) one *= 10;
    double whole = rint(scaled * one);
    if (whole >= 10 * one) whole = one, exponent++;
    output to = {.at = digits, .left = sizeof digits - 1};
    put_integer(&to, (long long)whole, "");
    int n = (int)(to.at - digits);
    while (n > 1 && digits[n - 1] == '0') n--;
    if (signbit(value)) put_text(out, "-", -1);
    if (exponent < -4 || exponent >= precision) {
        put(out, digits, 1);
        if (n > 1) put_text(out, ".", -1);
        put(out, digits + 1, (size_t)n - 1);
        put_text(out, exponent < 0 ? "e-" : "e+", -1);
        const int size = exponent < 0 ? -exponent : exponent;
        if (size < 10) put_text(out, "0", -1);
        put_integer(out, size, "");
        return;
    }
    for (int i = exponent < 0 ? exponent : 0; i < n || i <= exponent; i++) {
        if (i == exponent + 1) put_text(out, ".", -1);
        put(out, i >= 0 && i < n ? digits + i : "0", 1);
    }
}

void mukca_print_list(char *text, size_t size, const char *format, va_list args)
{
    output out = {.left = size - 1};
    out.at = text;
    while (*format) {
        const size_t plain = strcspn(format, "%");
        put(&out, format, plain);
        format += plain;
        if (!*format) break;
        const char *start = format++;
        int precision = -1;
        const char *plus = *format == '+' ? "+" : "";
        format += *plus != '\0';
        if (format[0] == '.' && format[1] == '*') {
            precision = va_arg(args, int);
            format += 2;
        } else if (*format == '.') {
            for (precision = 0, format++; *format >= '0' && *format <= '9'; format++)
                precision = 10 * precision + (*format - '0');
        }
        switch (*format) {
            case 's':
                put_text(&out, va_arg(args, const char *), precision);
                break;
            case 'd':
                put_integer(&out, va_arg(args, int), plus);
                break;
            case 'g':
                put_general(&out, va_arg(args, double), precision);
                break;
            case '%':
                put(&out, "%", 1);
                break;
            default:
                put(&out, start, (size_t)(format - start) + (*format != '\0'));
        }
        format += *format != '\0';
    }
    *out.at = '\0';
}

void mukca_print(char *text, size_t size, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    mukca_print_list(text, size, format, args);
    va_end(args);
}
