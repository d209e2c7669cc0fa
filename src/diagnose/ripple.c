/* The waves of gear ripple: all orders of a joint. */
#include "diagnose/ripple.h"

#include <math.h>

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

void mukca_ripple_start(double *wave, const mukca_recording *r, int joint)
{
    const int n_joints = r->chain->n_joints, n = r->n_samples;
    for (int i = 0; i < n; i++) {
        const double q = r->data->q[r->order[i] * n_joints + joint];
        wave[i] = wave[2 * n + i] = sin(q);
        wave[n + i] = wave[3 * n + i] = cos(q);
    }
    wave[4 * n] = 1;
}

/* By the recurrence of the addition theorem. */
void mukca_ripple_advance(double *F, double *wave, int n, const int *order, int count)
{
    for (int i = 0; i < n; i++) {
        double s = wave[i], c = wave[n + i];
        const double s1 = wave[2 * n + i], c1 = wave[3 * n + i];
        int at = (int)wave[4 * n];
        for (int o = 0; o < count; o++) {
            for (; at < order[o]; at++) {
                const double next = s * c1 + c * s1;
                c = c * c1 - s * s1;
                s = next;
            }
            *F++ = s, *F++ = c;
        }
        wave[i] = s, wave[n + i] = c;
    }
    if (count) wave[4 * n] = order[count - 1];
}
