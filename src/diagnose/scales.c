/* Prior scales of geometry and causes by evidence. */
#include "diagnose/scales.h"

#include <math.h>

static void choose_cause(mukca_unknowns *u, mukca_accepted *cause, mukca_evidence *evidence,
                         const mukca_normal_equations *normal)
{
    double scales[MUKCA_MAX_SIZES], weight[MUKCA_MAX_SIZES], best = -HUGE_VAL, chosen = 0;
    const int n = mukca_candidate_scales(scales, weight, &cause->candidate);
    for (int i = 0; i < n; i++) {
        cause->scale = scales[i];
        mukca_unknowns_prior(evidence->prior, u);
        const double value = weight[i] + mukca_evidence_evaluate(evidence, normal, u->sigma, NULL);
        if (value > best) best = value, chosen = scales[i];
    }
    cause->scale = chosen;
    mukca_unknowns_prior(evidence->prior, u);
}

void mukca_scales_choose(mukca_unknowns *u, mukca_evidence *evidence,
                         const mukca_recording *recording, const mukca_normal_equations *normal)
{
    /* Errors of published arms: links 0.5 to 4 mm, axes 1 to 10 mrad. */
    static const double lengths[] = {0.5e-3, 1e-3, 2e-3, 4e-3};
    static const double angles[] = {1e-3, 2.5e-3, 5e-3, 10e-3};
    enum { N = 4 };
    double best = -HUGE_VAL;
    int chosen = 0;
    for (int i = 0; i <= N * N; i++) {
        const int k = i < N * N ? i : chosen;
        u->sigma_length = lengths[k / N], u->sigma_angle = angles[k % N];
        mukca_unknowns_set_geometry_prior(u, recording);
        mukca_unknowns_prior(evidence->prior, u);
        if (i == N * N) break;
        const double value = mukca_evidence_evaluate(evidence, normal, u->sigma, NULL);
        if (value > best) best = value, chosen = k;
    }
    for (int c = 0; c < u->n_causes; c++)
        if (!u->cause[c].known && !u->cause[c].sized)
            choose_cause(u, &u->cause[c], evidence, normal);
}
