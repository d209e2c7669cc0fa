/* Quantiles, log-domain sums and tails, and a one-dimensional minimiser. */
#include "math/stats.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void mukca_stats_sort(double *x, int n)
{
    qsort(x, (size_t)n, sizeof *x, compare);
}

double mukca_stats_quantile(double *x, int n, double p)
{
    if (n <= 0) return 0;
    for (int i = 0; i < n; i++)
        if (x[i] != x[i]) return x[i];
    mukca_stats_sort(x, n);
    double at = p * (n - 1);
    int i = at <= 0 ? 0 : at >= n - 1 ? n - 1 : (int)at;
    double rest = at - i;
    return i + 1 < n && rest > 0 ? x[i] + rest * (x[i + 1] - x[i]) : x[i];
}

double mukca_stats_median(double *x, int n)
{
    return mukca_stats_quantile(x, n, 0.5);
}

double mukca_stats_log_sum_exp(const double *x, int n)
{
    double max = -HUGE_VAL, sum = 0;
    for (int i = 0; i < n; i++) {
        if (x[i] != x[i]) return x[i];
        if (x[i] > max) max = x[i];
    }
    if (isinf(max)) return max;
    for (int i = 0; i < n; i++) sum += exp(x[i] - max);
    return max + log(sum);
}

double mukca_stats_log_normal_cdf(double z)
{
    if (z > 0) return log1p(-0.5 * erfc(z * M_SQRT1_2));
    if (!(z < -20)) return log(0.5 * erfc(-z * M_SQRT1_2));
    /* Phi(z) = phi(z) / -z * (1 - 1/z^2 + 3/z^4 - 15/z^6 + ...), Abramowitz and Stegun 26.2.12 */
    double u = 1 / (z * z), series = 1 - u * (1 - 3 * u * (1 - 5 * u * (1 - 7 * u * (1 - 9 * u))));
    return -0.5 * z * z - 0.5 * log(2 * M_PI) - log(-z) + log(series);
}

double mukca_stats_minimize(double *value, double (*f)(void *, double), void *context, double lo,
                            double hi, double tolerance)
{
    const double golden = 0.3819660112501051;
    double x = lo + golden * (hi - lo), w = x, v = x, step = 0, before = 0; /* Brent 1973, ch. 5 */
    double fx = f(context, x), fw = fx, fv = fx;
    for (int i = 0; i < 200; i++) {
        double middle = 0.5 * (lo + hi), tol = 0.5 * tolerance + 2 * DBL_EPSILON * fabs(x);
        if (fabs(x - middle) <= 2 * tol - 0.5 * (hi - lo)) break;
        double r = (x - w) * (fx - fv), q = (x - v) * (fx - fw), p = (x - v) * q - (x - w) * r;
        q = 2 * (q - r);
        if (q > 0) p = -p;
        q = fabs(q);
        if (fabs(before) > tol && fabs(p) < fabs(0.5 * q * before) && p > q * (lo - x) &&
            p < q * (hi - x)) { /* the parabola's minimum lies inside the interval, within half the
                                   last step but one */
            before = step;
            step = p / q;
            if (x + step - lo < 2 * tol || hi - x - step < 2 * tol)
                step = copysign(tol, middle - x);
        } else {
            before = x < middle ? hi - x : lo - x;
            step = golden * before;
        }
        double u = x + (fabs(step) >= tol ? step : copysign(tol, step)), fu = f(context, u);
        if (fu <= fx) {
            if (u < x)
                hi = x;
            else
                lo = x;
            v = w, fv = fw, w = x, fw = fx, x = u, fx = fu;
        } else {
            if (u < x)
                lo = u;
            else
                hi = u;
            if (fu <= fw || w == x)
                v = w, fv = fw, w = u, fw = fu;
            else if (fu <= fv || v == x || v == w)
                v = u, fv = fu;
        }
    }
    if (value) *value = fx;
    return x;
}
