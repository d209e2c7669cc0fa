/* Sweeps over many samples at once: predictions and the adjoint gradient. */
#include "fit/sweep.h"

#include <string.h>

#include "fit/rows.h"
#include "math/sincos.h"

/* A with A e_z = axis; the identity if the axis is z. */
static void align_axis(double A[9], const double axis[3])
{
    double e1[3], e2[3];
    memcpy(A, identity, sizeof identity);
    if (axis[0] == 0 && axis[1] == 0 && axis[2] > 0) return;
    mukca_rotation_transverse(e1, e2, axis);
    for (int i = 0; i < 3; i++) A[3 * i] = e1[i], A[3 * i + 1] = e2[i], A[3 * i + 2] = axis[i];
}

void mukca_sweep_take(mukca_sweep *sweep, mukca_pool *pool, const mukca_chain *chain, int rows)
{
    const int n = chain->n_elements, joints = chain->n_joints;
    const int padded = (rows + LANES - 1) / LANES * LANES;
    const int widest = padded < MUKCA_SWEEP_WINDOW ? padded : MUKCA_SWEEP_WINDOW;
    memset(sweep, 0, sizeof *sweep);
    sweep->n_elements = n;
    sweep->n_joints = joints;
    sweep->n_rows = rows;
    sweep->n_windows = (rows + MUKCA_SWEEP_WINDOW - 1) / MUKCA_SWEEP_WINDOW;
    memcpy(sweep->align[0], identity, sizeof identity);
    for (int k = 0; k < n; k++) {
        const mukca_element *e = &chain->element[k];
        sweep->type[k] = (int)e->type;
        sweep->joint[k] = e->joint;
        align_axis(sweep->align[k + 1], e->type == MUKCA_FIXED ? identity + 6 : e->axis);
    }
    sweep->turns = MUKCA_TAKE(pool, double, 2L * joints * padded);
    sweep->x = MUKCA_TAKE(pool, double, 3 * widest);
    sweep->h = MUKCA_TAKE(pool, double, 3 * widest);
    sweep->w = MUKCA_TAKE(pool, double, n * 3 * widest);
    sweep->Q = MUKCA_TAKE(pool, double, 9 * widest);
}

bool mukca_sweep_open(mukca_sweep *sweep, int window)
{
    if (window >= sweep->n_windows) return false;
    sweep->from = window * MUKCA_SWEEP_WINDOW;
    const int left = sweep->n_rows - sweep->from;
    sweep->rows = left < MUKCA_SWEEP_WINDOW ? left : MUKCA_SWEEP_WINDOW;
    sweep->padded = (sweep->rows + LANES - 1) / LANES * LANES;
    sweep->sine = sweep->turns + 2L * sweep->n_joints * sweep->from;
    sweep->cosine = sweep->sine + sweep->n_joints * sweep->padded;
    return true;
}

/* Joint angles of the open window, q[rows][n_joints]. */
static void load_window(mukca_sweep *sweep, const mukca_chain *chain, const double *q)
{
    const int padded = sweep->padded, last = sweep->rows - 1;
    for (int j = 0; j < sweep->n_joints; j++) {
        double *angle = sweep->h, *sine = sweep->sine + j * padded;
        for (int i = 0; i < padded; i++) /* padding repeats the last sample */
            angle[i] = q[(i < last ? i : last) * sweep->n_joints + j];
        if (mukca_joint_turns(sweep->type[chain->joint_element[j]]))
            mukca_sincos(sine, sweep->cosine + j * padded, angle, padded);
        else
            memcpy(sine, angle, (size_t)padded * sizeof *sine);
    }
}

void mukca_sweep_load(mukca_sweep *sweep, const mukca_chain *chain, const double *q)
{
    for (int v = 0; mukca_sweep_open(sweep, v); v++)
        load_window(sweep, chain, q + (long)sweep->from * sweep->n_joints);
}

void mukca_sweep_origins(mukca_sweep *sweep, const double *theta)
{
    for (int k = 0; k < sweep->n_elements; k++) {
        double R[9];
        mukca_rotation_from_rpy(R, theta + 6 * k + 3);
        conjugate(sweep->R[k], sweep->align[k], R, sweep->align[k + 1]);
        mukca_mat3_tvec(sweep->p[k], sweep->align[k], theta + 6 * k);
    }
}

MUKCA_CLONES void mukca_sweep_forward(mukca_sweep *sweep)
{
    const int padded = sweep->padded, n = sweep->n_elements;
    for (int k = n - 1; k >= 0; k--) {
        double *w = sweep->w + 3 * k * padded;
        if (k < n - 1)
            map_rows(w, sweep->R[k + 1], sweep->p[k + 1], w + 3 * padded, padded);
        else
            memset(w, 0, 3 * (size_t)padded * sizeof *w);
        if (mukca_joint_turns(sweep->type[k])) turn_rows(w, sweep, k, 1);
        for (int i = 0; i < padded && sweep->type[k] == MUKCA_PRISMATIC; i++)
            w[2 * padded + i] += sweep->sine[sweep->joint[k] * padded + i];
    }
    map_rows(sweep->x, sweep->R[0], sweep->p[0], sweep->w, padded);
}

#define SUM4(v) (((v)[0] + (v)[1]) + ((v)[2] + (v)[3]))

/* sum[3] of h and outer[9] of h w', over all samples. */
MUKCA_INLINE void sum_rows(double sum[3], double outer[9], const double *h, const double *w,
                           int padded)
{
    for (int r = 0; r < 3; r++) {
        const double *hr = h + r * padded;
        four s = {0}, x = {0}, y = {0}, z = {0};
        for (int i = 0; i < padded; i += 4) {
            const four v = LOAD4(hr + i);
            s += v;
            x += v * LOAD4(w + i);
            y += v * LOAD4(w + padded + i);
            z += v * LOAD4(w + 2 * padded + i);
        }
        sum[r] = SUM4(s);
        outer[3 * r] = SUM4(x), outer[3 * r + 1] = SUM4(y), outer[3 * r + 2] = SUM4(z);
    }
}

MUKCA_CLONES void mukca_sweep_backward(mukca_adjoint *adjoint, mukca_sweep *sweep)
{
    const int padded = sweep->padded;
    double *h = sweep->h;
    for (int k = 0; k < sweep->n_elements; k++) {
        double sum[3], outer[9], moved[3], half[9], Rt[9], At[9];
        sum_rows(sum, outer, h, sweep->w + 3 * k * padded, padded);
        mukca_mat3_vec(moved, sweep->align[k], sum);
        transpose(At, sweep->align[k + 1]);
        mukca_mat3_mul(half, sweep->align[k], outer);
        mukca_mat3_mul(outer, half, At);
        for (int i = 0; i < 3; i++) adjoint->sum[k][i] += moved[i];
        for (int i = 0; i < 9; i++) adjoint->outer[k][i] += outer[i];
        transpose(Rt, sweep->R[k]);
        map_rows(h, Rt, NULL, h, padded);
        if (mukca_joint_turns(sweep->type[k])) turn_rows(h, sweep, k, -1);
    }
}

void mukca_sweep_element_derivative(double dR[3][9], const double rpy[3], mukca_gradient gradient)
{
    if (gradient == MUKCA_GRADIENT_ANALYTIC) {
        mukca_rotation_from_rpy_derivative(dR, rpy);
        return;
    }
    /* Central differences of fourth order: the entries are sines and cosines, for which this step
     * balances rounding (1e-13) and truncation (h^4 / 30). */
    static const double step = 1e-3;
    for (int i = 0; i < 3; i++) {
        double R[9], at[3] = {rpy[0], rpy[1], rpy[2]};
        static const double weight[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
        static const double moves[4] = {-2, -1, 1, 2};
        memset(dR[i], 0, sizeof dR[i]);
        for (int s = 0; s < 4; s++) {
            at[i] = rpy[i] + moves[s] * step;
            mukca_rotation_from_rpy(R, at);
            for (int c = 0; c < 9; c++) dR[i][c] += weight[s] / step * R[c];
        }
    }
}
