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

double mukca_gaussians_quantile(const mukca_gaussians *m, double p)
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
