/* Signals on a uniform time grid: zero-phase low-pass filter, differences, decimation.
 *
 * A signal is x[rows][ld], row-major, of which the first `width` columns are used: angles of all
 * joints, or columns of a regression.  The caller cuts it at gaps in time.
 */
#ifndef MUKCA_DYNAMICS_SIGNALS_H
#define MUKCA_DYNAMICS_SIGNALS_H

#include <stddef.h>

enum { MUKCA_LOWPASS_MOST_ORDER = 8 };

/* Butterworth filter as second-order sections. */
typedef struct {
    int n_sections;
    int pad; /* samples by which either end is extended: three periods of the cutoff */
    struct {
        double b[3], a[2]; /* a0 = 1 */
        double rest[2];    /* state for a constant input of 1 */
    } section[(MUKCA_LOWPASS_MOST_ORDER + 1) / 2];
} mukca_lowpass;

/* Low-pass of 1 .. MUKCA_LOWPASS_MOST_ORDER (SciPy: butter(order, cutoff / (rate / 2),
 * output="sos")); cutoff > 0 in Hz (-3 dB of one pass, -6 dB of mukca_lowpass_apply), rate in Hz. A
 * cutoff above 0.95 of rate / 2 is lowered to it. */
void mukca_lowpass_set(mukca_lowpass *lowpass, int order, double cutoff, double rate);

/* Doubles of scratch memory to filter so many rows. */
static inline size_t mukca_lowpass_scratch(const mukca_lowpass *lowpass, int rows)
{
    return (size_t)rows + 2 * (size_t)lowpass->pad;
}

/* Filter x[rows][ld] in place forwards and backwards: no phase shift, constants unchanged,
 * ends extended oddly (SciPy: sosfiltfilt(sos, x, axis=0, padtype="odd",
 * padlen=min(pad, rows - 2))).  Fewer than 3 rows are left unchanged.
 * scratch[mukca_lowpass_scratch(lowpass, rows)]. */
void mukca_lowpass_apply(double *x, int rows, int width, int ld, const mukca_lowpass *lowpass,
                         double *scratch);

/* Derivatives dx[rows][width] of x[rows][width] with the time step `dt` in s: central differences,
 * one-sided at both ends (numpy.gradient).  rows >= 2; not in place. */
void mukca_differences(double *dx, const double *x, int rows, int width, double dt);

/* Keep rows 0, step, 2 step ... of x[rows][width] in place; returns their number. */
int mukca_decimate(double *x, int rows, int width, int step);

#endif
