/* Noise sigma of maximal evidence. */
#include "diagnose/noise.h"

#include <math.h>

#include "math/stats.h"

/* Range of the search, m: from below any encoder to far above any arm. */
#define LEAST_NOISE 1e-6
#define MOST_NOISE 5e-2

/* Log evidence behind the best family from which one is negligible (3 million to 1). */
#define NEGLIGIBLE 15.0

typedef struct {
    mukca_evidence *evidence;
    const mukca_normal_equations *normal;
} along_noise;

static double minus_evidence(void *context, double log_sigma)
{
    const along_noise *a = context;
    return -mukca_evidence_evaluate(a->evidence, a->normal, exp(log_sigma), NULL);
}

double mukca_noise_choose(mukca_evidence *evidence, const mukca_normal_equations *normal,
                          double guess, double *value)
{
    const double tolerance = 0.01; /* a hundredth of sigma: far below its uncertainty */
    along_noise context = {evidence, normal};
    double best, lo = log(guess / 2), hi = log(2 * guess);
    double x = mukca_stats_minimize(&best, minus_evidence, &context, lo, hi, tolerance);
    if (x < lo + 5 * tolerance || x > hi - 5 * tolerance) /* a bad guess: search the whole range */
        x = mukca_stats_minimize(&best, minus_evidence, &context, log(LEAST_NOISE), log(MOST_NOISE),
                                 tolerance);
    if (value) *value = -best;
    return exp(x);
}

bool mukca_noise_contends(const mukca_evidence *evidence, int index, double best)
{
    /* the other coefficient may have gained as much as the best one has changed */
    return evidence->normal[index].behind - fabs(best - evidence->best) <= NEGLIGIBLE;
}
