/* Sine and cosine of an array of angles. */
#include <math.h>

#include "math/sincos_lanes.h"

MUKCA_CLONES bool mukca_sincos_near(double *s, double *c, const double *x, int n)
{
    lane_bits wide = {0};
    int i = 0;
    for (; i + MUKCA_LANES <= n; i += MUKCA_LANES) sincos_lanes(s + i, c + i, &wide, x + i);
#if MUKCA_LANES > 1
    if (i < n) {
        /* built in a register: loading a copy from memory would stall */
        const int left = n - i;
        const lanes last = {x[i], left > 1 ? x[i + 1] : 0, left > 2 ? x[i + 2] : 0, 0};
        sincos_lanes(s + i, c + i, &wide, (const double *)&last);
    }
#endif
    return !ANY_LANE(wide);
}

void mukca_sincos(double *s, double *c, const double *x, int n)
{
    if (mukca_sincos_near(s, c, x, n)) return;
    for (int i = 0; i < n; i++)
        if (!(fabs(x[i]) <= MUKCA_SINCOS_LARGEST)) s[i] = sin(x[i]), c[i] = cos(x[i]);
}
