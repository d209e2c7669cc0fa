/* Transmission ripple: waves of all orders of a joint. */
#include "diagnose/ripple.h"

#include <math.h>

#include "base/clones.h"

double mukca_ripple_log_prior(int order)
{
    /* Ratios of strain wave and cycloidal gears in cobots, their doubles (two lobes a turn), and
     * encoder line counts that alias onto low orders. */
    static const int usual[] = {50,  51,  80,  81,  100, 101, 102, 120, 121, 128,
                                160, 161, 200, 202, 240, 242, 256, 320, 322};
    const int n_usual = (int)(sizeof usual / sizeof *usual);
    double p = 0.3 / 399;
    if (order <= 6) p += 0.4 / 5;
    for (int i = 0; i < n_usual; i++)
        if (usual[i] == order) p += 0.3 / n_usual;
    return log(p);
}

void mukca_ripple_start(mukca_ripple *wave, const mukca_recording *r, int joint)
{
    const int n_joints = r->chain->n_joints, n = r->n_samples;
    for (int i = 0; i < n; i++) {
        const double q = r->q[r->order[i] * n_joints + joint];
        wave->first[i] = wave->sine[i] = sin(q);
        wave->first[n + i] = wave->cosine[i] = cos(q);
    }
    wave->n = n;
    wave->order = 1;
}

/* By the angle addition formulas. */
MUKCA_CLONES void mukca_ripple_next(mukca_ripple *wave)
{
    const int n = wave->n;
    const double *restrict s1 = wave->first, *restrict c1 = s1 + n;
    double *restrict sine = wave->sine, *restrict cosine = wave->cosine;
    for (int i = 0; i < n; i++) {
        const double s = sine[i], c = cosine[i];
        sine[i] = s * c1[i] + c * s1[i];
        cosine[i] = c * c1[i] - s * s1[i];
    }
    wave->order++;
}
