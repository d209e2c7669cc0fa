/* Sweeps over many samples at once: orientations and the Jacobian. */
#include "fit/poses.h"

#include <string.h>

#include "fit/rows.h"

/* Q := Q R Rz(q) for every sample: the rows of Q are vectors x[3][padded], multiplied by R from the
 * right. */
MUKCA_INLINE void frames_times(double *Q, const double R[9], const mukca_sweep *sweep, int k)
{
    double Rt[9];
    transpose(Rt, R);
    for (int row = 0; row < 3; row++) {
        double *q = Q + 3 * row * sweep->padded;
        map_rows(q, Rt, NULL, q, sweep->padded);
        if (k >= 0 && mukca_joint_turns(sweep->type[k])) turn_rows(q, sweep, k, -1);
    }
}

MUKCA_INLINE void frames_start(double *Q, int padded)
{
    for (int c = 0; c < 9; c++)
        for (int i = 0; i < padded; i++) Q[c * padded + i] = identity[c];
}

MUKCA_CLONES void mukca_sweep_orientations(mukca_sweep *sweep)
{
    double back[9]; /* from aligned to true coordinates of the last frame */
    transpose(back, sweep->align[sweep->n_elements]);
    frames_start(sweep->Q, sweep->padded);
    for (int k = 0; k < sweep->n_elements; k++) frames_times(sweep->Q, sweep->R[k], sweep, k);
    frames_times(sweep->Q, back, sweep, -1);
}

void mukca_sweep_spin(double omega[3], const double dR[9], const double R[9])
{
    double Rt[9], spin[9];
    transpose(Rt, R);
    mukca_mat3_mul(spin, dR, Rt);
    omega[0] = 0.5 * (spin[7] - spin[5]);
    omega[1] = 0.5 * (spin[2] - spin[6]);
    omega[2] = 0.5 * (spin[3] - spin[1]);
}

/* Column `column` of J: sample i gets Q_i v_i.  v[3] is the same for all samples; with `each`,
 * v[3][padded] has one per sample. */
MUKCA_INLINE void column_rows(double *J, int ld, int column, const double *v, bool each,
                              const mukca_sweep *sweep)
{
    const int padded = sweep->padded, rows = sweep->rows, stride = each ? padded : 1;
    const double *Q = sweep->Q;
    for (int start = 0; start < rows; start += LANES) {
        double out[3][LANES];
        for (int r = 0; r < 3; r++)
            for (int l = 0; l < LANES; l++) {
                const int i = start + l;
                double s = 0;
                for (int c = 0; c < 3; c++)
                    s += Q[(3 * r + c) * padded + i] * v[c * stride + each * i];
                out[r][l] = s;
            }
        for (int l = 0; l < LANES && start + l < rows; l++)
            for (int r = 0; r < 3; r++) J[(3 * (start + l) + r) * ld + column] = out[r][l];
    }
}

MUKCA_CLONES void mukca_sweep_jacobian(double *J, double *JO, mukca_sweep *sweep,
                                       const double *theta, const mukca_parameters *parameters,
                                       mukca_gradient gradient)
{
    const int n = parameters->n, padded = sweep->padded;
    const short *index = parameters->index;
    static const double none[3] = {0, 0, 0};
    double *v = sweep->x; /* scratch */
    frames_start(sweep->Q, padded);
    for (int k = 0, column = 0; k < sweep->n_elements && column < n; k++) {
        double dR[3][9], M[9], omega[3];
        if (index[column] / MUKCA_PARAMETERS == k)
            mukca_sweep_element_derivative(dR, theta + 6 * k + 3, gradient);
        for (; column < n && index[column] / MUKCA_PARAMETERS == k; column++) {
            const int parameter = index[column] % MUKCA_PARAMETERS;
            if (parameter < 3) { /* the parent frame's axis, in aligned coordinates */
                column_rows(J, n, column, sweep->align[k] + 3 * parameter, false, sweep);
                if (JO) column_rows(JO, n, column, none, false, sweep);
                continue;
            }
            conjugate(M, sweep->align[k], dR[parameter - 3], sweep->align[k + 1]);
            map_rows(v, M, NULL, sweep->w + 3 * k * padded, padded);
            column_rows(J, n, column, v, true, sweep);
            if (!JO) continue;
            mukca_sweep_spin(omega, M, sweep->R[k]);
            column_rows(JO, n, column, omega, false, sweep);
        }
        frames_times(sweep->Q, sweep->R[k], sweep, k);
    }
}
