/* A mixture of Gaussians. */
#include "infer/gaussians.h"

#include <math.h>

void mukca_gaussians_add(mukca_gaussians *m, double mean, double variance, double weight)
{
    if (!isfinite(mean) || m->n == MUKCA_MOST_GAUSSIANS) return;
    m->mean[m->n] = mean;
    m->deviation[m->n] = sqrt(fmax(variance, 1e-30));
    m->weight[m->n++] = weight;
}

static double quantile(const mukca_gaussians *m, double p)
{
    double low = HUGE_VAL, high = -HUGE_VAL, total = 0;
    for (int i = 0; i < m->n; i++) {
        total += m->weight[i];
        low = fmin(low, m->mean[i] - 5 * m->deviation[i]);
        high = fmax(high, m->mean[i] + 5 * m->deviation[i]);
    }
    for (int step = 0; step < 60; step++) {
        const double middle = 0.5 * (low + high);
        double below = 0;
        for (int i = 0; i < m->n; i++)
            below += m->weight[i] * 0.5 *
                     erfc((m->mean[i] - middle) / m->deviation[i] * 0.70710678118654752440);
        *(below < p * total ? &low : &high) = middle;
    }
    return 0.5 * (low + high);
}

mukca_estimate mukca_gaussians_estimate(const mukca_gaussians *m, double scale, bool positive)
{
    double total = 0, mean = 0;
    if (m->n == 0) return MUKCA_ESTIMATE_NONE;
    for (int i = 0; i < m->n; i++) total += m->weight[i], mean += m->weight[i] * m->mean[i];
    const double low = quantile(m, 0.025);
    return (mukca_estimate){scale * mean / total, scale * (positive ? fmax(low, 0) : low),
                            scale * quantile(m, 0.975)};
}
