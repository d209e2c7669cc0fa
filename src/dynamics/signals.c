/* Zero-phase Butterworth filter as second-order sections, differences, decimation. */
#include "dynamics/signals.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* Largest cutoff as a share of rate / 2: the bilinear transform's tangent diverges at 1. */
static const double largest_cutoff = 0.95;

void mukca_lowpass_set(mukca_lowpass *lowpass, int order, double cutoff, double rate)
{
    const double share = fmin(cutoff / (0.5 * rate), largest_cutoff);
    const double K = tan(0.5 * M_PI * share); /* prewarped cutoff of the bilinear transform */
    *lowpass = (mukca_lowpass){.n_sections = (order + 1) / 2, .pad = (int)(6 / share)};
    for (int i = 0; i < lowpass->n_sections; i++) {
        double *b = lowpass->section[i].b, *a = lowpass->section[i].a;
        if (2 * i + 1 == order) { /* the real pole of an odd order */
            b[0] = b[1] = K / (1 + K);
            a[0] = (K - 1) / (K + 1);
        } else { /* the pair of poles with damping sin(pi (2 i + 1) / (2 order)) */
            const double damping = sin(M_PI * (2 * i + 1) / (2 * order));
            const double D = 1 + 2 * damping * K + K * K;
            b[0] = b[2] = K * K / D;
            b[1] = 2 * b[0];
            a[0] = 2 * (K * K - 1) / D;
            a[1] = (1 - 2 * damping * K + K * K) / D;
        }
        lowpass->section[i].rest[0] = 1 - b[0]; /* the gain of a section at 0 Hz is 1 */
        lowpass->section[i].rest[1] = b[2] - a[1];
    }
}

/* One pass over x[n] in place, backwards if step is -1; transposed direct form II, started as if
 * the first value had been there for ever. */
static void pass(double *x, int n, int step, const mukca_lowpass *lowpass)
{
    for (int i = 0; i < lowpass->n_sections; i++) {
        const double *b = lowpass->section[i].b, *a = lowpass->section[i].a;
        double *at = step > 0 ? x : x + n - 1;
        double z0 = lowpass->section[i].rest[0] * *at, z1 = lowpass->section[i].rest[1] * *at;
        for (int r = 0; r < n; r++, at += step) {
            const double in = *at, out = b[0] * in + z0;
            z0 = b[1] * in - a[0] * out + z1;
            z1 = b[2] * in - a[1] * out;
            *at = out;
        }
    }
}

void mukca_lowpass_apply(double *x, int rows, int width, int ld, const mukca_lowpass *lowpass,
                         double *scratch)
{
    if (rows < 3) return;
    const int pad = lowpass->pad < rows - 2 ? lowpass->pad : rows - 2, last = rows - 1;
    for (int c = 0; c < width; c++) {
        for (int r = -pad; r < rows + pad; r++) { /* odd about either end */
            const int end = r < 0 ? 0 : last, mirror = r < 0 ? -r : 2 * last - r;
            const bool inside = r >= 0 && r <= last;
            scratch[r + pad] = inside ? x[(size_t)ld * (size_t)r + (size_t)c]
                                      : 2 * x[(size_t)ld * (size_t)end + (size_t)c] -
                                            x[(size_t)ld * (size_t)mirror + (size_t)c];
        }
        pass(scratch, rows + 2 * pad, 1, lowpass);
        pass(scratch, rows + 2 * pad, -1, lowpass);
        for (int r = 0; r < rows; r++) x[(size_t)ld * (size_t)r + (size_t)c] = scratch[r + pad];
    }
}

void mukca_differences(double *dx, const double *x, int rows, int width, double dt)
{
    for (int r = 0; r < rows; r++) {
        const int before = r > 0 ? r - 1 : 0, after = r < rows - 1 ? r + 1 : r;
        const double *a = x + (size_t)before * (size_t)width,
                     *b = x + (size_t)after * (size_t)width;
        double *out = dx + (size_t)r * (size_t)width;
        for (int c = 0; c < width; c++) out[c] = (b[c] - a[c]) / (dt * (after - before));
    }
}

int mukca_decimate(double *x, int rows, int width, int step)
{
    int kept = 0;
    for (int r = 0; r < rows; r += step, kept++)
        memmove(x + (size_t)kept * (size_t)width, x + (size_t)r * (size_t)width,
                sizeof *x * (size_t)width);
    return kept;
}
