/* Running mean and standard deviation (Welford's algorithm), and a logarithmic histogram for
 * medians. */
#include "recalibrate/errors.h"

#include <math.h>

void mukca_moments_add(mukca_moments *m, double x)
{
    m->n++;
    if (!(x <= m->max)) m->max = x;
    const double step = x - m->mean;
    m->mean += step / (double)m->n;
    m->m2 += step * (x - m->mean);
}

double mukca_moments_std(const mukca_moments *moments)
{
    return moments->n > 1 ? sqrt(moments->m2 / (double)(moments->n - 1)) : 0;
}

static void histogram_add(mukca_histogram *h, double x)
{
    int exponent = 0, bin = 0;
    if (x > 0x1p-60 && x < 0x1p9) {
        const double mantissa = frexp(x, &exponent); /* 0.5 .. 1 */
        bin = (exponent + 60) * 32 + (int)((mantissa - 0.5) * 64);
    } else if (x > 1) {
        bin = MUKCA_HISTOGRAM_BINS - 1;
    }
    h->count[bin]++;
    h->total++;
}

double mukca_histogram_median(const mukca_histogram *histogram)
{
    double below = 0, half = 0.5 * histogram->total;
    for (int bin = 0; bin < MUKCA_HISTOGRAM_BINS; bin++) {
        const double here = histogram->count[bin];
        if (here > 0 && below + here >= half) {
            const double at = bin % 32 + (half - below) / here;
            return bin == 0 ? 0 : ldexp(0.5 + at / 64, bin / 32 - 60);
        }
        below += here;
    }
    return 0;
}

void mukca_pose_errors_add(mukca_pose_errors *errors, const mukca_pose_look *look)
{
    const double length = mukca_norm3(look->position);
    mukca_moments_add(&errors->position, length);
    histogram_add(&errors->position_histogram, length);
    for (int i = 0; i < 3; i++)
        mukca_moments_add(&errors->position_axis[i], fabs(look->position[i]));
    if (!isfinite(look->rotation[0])) return;
    const double angle = mukca_norm3(look->rotation);
    mukca_moments_add(&errors->rotation, angle);
    histogram_add(&errors->rotation_histogram, angle);
    for (int i = 0; i < 3; i++)
        mukca_moments_add(&errors->rotation_axis[i], fabs(look->rotation_error[i]));
}
