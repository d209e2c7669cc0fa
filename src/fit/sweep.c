/* Sweeps over many samples at once: predictions, adjoint gradient, Jacobian. */
#include "fit/sweep.h"

#include <math.h>
#include <string.h>

#include "math/four.h"

enum { LANES = 8 };

static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/* A with A e_z = axis; the identity where the axis is z already. */
static void align_axis(double A[9], const double axis[3])
{
    double e1[3], e2[3];
    memcpy(A, identity, sizeof identity);
    if (axis[0] == 0 && axis[1] == 0 && axis[2] > 0) return;
    mukca_rotation_transverse(e1, e2, axis);
    for (int i = 0; i < 3; i++) A[3 * i] = e1[i], A[3 * i + 1] = e2[i], A[3 * i + 2] = axis[i];
}

void mukca_sweep_carve(mukca_sweep *sweep, mukca_arena *arena, const mukca_chain *chain, int rows)
{
    const int n = chain->n_elements, joints = chain->n_joints;
    const int padded = (rows + LANES - 1) / LANES * LANES;
    memset(sweep, 0, sizeof *sweep);
    sweep->n_elements = n;
    sweep->n_joints = joints;
    sweep->n_rows = rows;
    sweep->padded = padded;
    memcpy(sweep->align[0], identity, sizeof identity);
    for (int k = 0; k < n; k++) {
        const mukca_element *e = &chain->element[k];
        sweep->type[k] = (int)e->type;
        sweep->joint[k] = e->joint;
        align_axis(sweep->align[k + 1], e->type == MUKCA_FIXED ? identity + 6 : e->axis);
    }
    sweep->sine = MUKCA_CARVE(arena, double, joints *padded);
    sweep->cosine = MUKCA_CARVE(arena, double, joints *padded);
    sweep->x = MUKCA_CARVE(arena, double, 3 * padded);
    sweep->w = MUKCA_CARVE(arena, double, n * 3 * padded);
    sweep->Q = MUKCA_CARVE(arena, double, 9 * padded);
}

static void transpose(double At[9], const double A[9])
{
    for (int i = 0; i < 9; i++) At[i] = A[3 * (i % 3) + i / 3];
}

/* B = A' M C for 3x3 matrices. */
static void conjugate(double B[9], const double A[9], const double M[9], const double C[9])
{
    double MC[9], At[9];
    transpose(At, A);
    mukca_mat3_mul(MC, M, C);
    mukca_mat3_mul(B, At, MC);
}

void mukca_sweep_load(mukca_sweep *sweep, const mukca_chain *chain, const double *q)
{
    const int padded = sweep->padded, last = sweep->n_rows - 1;
    for (int j = 0; j < sweep->n_joints; j++) {
        const bool turning = mukca_joint_turns(sweep->type[chain->joint_element[j]]);
        for (int i = 0; i < padded; i++) { /* padding repeats the last row */
            const double angle = q[(i < last ? i : last) * sweep->n_joints + j];
            sweep->sine[j * padded + i] = turning ? sin(angle) : angle;
            sweep->cosine[j * padded + i] = turning ? cos(angle) : 1;
        }
    }
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

/* y[3][padded] = M x (+ p), M and p the same for all rows; y may be x. */
MUKCA_INLINE void map_rows(double *y, const double M[9], const double *p, const double *x,
                           int padded)
{
    const double *xs = x, *ys = x + padded, *zs = x + 2 * padded;
    const double px = p ? p[0] : 0, py = p ? p[1] : 0, pz = p ? p[2] : 0;
    for (int i = 0; i < padded; i += LANES) {
        double a[LANES], b[LANES], c[LANES];
        for (int l = 0; l < LANES; l++) {
            a[l] = M[0] * xs[i + l] + M[1] * ys[i + l] + M[2] * zs[i + l] + px;
            b[l] = M[3] * xs[i + l] + M[4] * ys[i + l] + M[5] * zs[i + l] + py;
            c[l] = M[6] * xs[i + l] + M[7] * ys[i + l] + M[8] * zs[i + l] + pz;
        }
        memcpy(y + i, a, sizeof a);
        memcpy(y + padded + i, b, sizeof b);
        memcpy(y + 2 * padded + i, c, sizeof c);
    }
}

/* x[3][padded] := Rz(q) x with the angles of element k's joint, backwards for sign = -1. */
MUKCA_INLINE void turn_rows(double *restrict x, const mukca_sweep *sweep, int k, double sign)
{
    const int padded = sweep->padded;
    const double *restrict s = sweep->sine + sweep->joint[k] * padded;
    const double *restrict c = sweep->cosine + sweep->joint[k] * padded;
    double *restrict y = x + padded;
    for (int i = 0; i < padded; i++) {
        const double a = x[i], b = y[i], sine = sign * s[i];
        x[i] = c[i] * a - sine * b;
        y[i] = sine * a + c[i] * b;
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

/* Q := Q R Rz(q) for every row: the rows of Q are x[3][padded] vectors times R from the right. */
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

#define SUM4(v) (((v)[0] + (v)[1]) + ((v)[2] + (v)[3]))

/* sum[3] of h, and outer[9] of h w', over all rows. */
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

MUKCA_CLONES void mukca_sweep_backward(mukca_adjoint *adjoint, double *h, mukca_sweep *sweep)
{
    const int padded = sweep->padded;
    for (int k = 0; k < sweep->n_elements; k++) {
        double sum[3], outer[9], half[9], Rt[9], At[9];
        sum_rows(sum, outer, h, sweep->w + 3 * k * padded, padded);
        mukca_mat3_vec(adjoint->sum[k], sweep->align[k], sum);
        transpose(At, sweep->align[k + 1]);
        mukca_mat3_mul(half, sweep->align[k], outer);
        mukca_mat3_mul(adjoint->outer[k], half, At);
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
    /* Central differences of fourth order: the element's entries are sines and cosines, so that
     * this step balances rounding (1e-13) and truncation (h^4 / 30). */
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

void mukca_sweep_spin(double omega[3], const double dR[9], const double R[9])
{
    double Rt[9], spin[9];
    transpose(Rt, R);
    mukca_mat3_mul(spin, dR, Rt);
    omega[0] = 0.5 * (spin[7] - spin[5]);
    omega[1] = 0.5 * (spin[2] - spin[6]);
    omega[2] = 0.5 * (spin[3] - spin[1]);
}

/* Column `column` of J: row i gets Q_i v_i.  v[3] is the same for all rows, or `each` has one,
 * v[3][padded]. */
MUKCA_INLINE void column_rows(double *J, int ld, int column, const double *v, bool each,
                              const mukca_sweep *sweep)
{
    const int padded = sweep->padded, rows = sweep->n_rows, stride = each ? padded : 1;
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
    double *v = sweep->x; /* scratch; the predictions are recomputed below */
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
    map_rows(sweep->x, sweep->R[0], sweep->p[0], sweep->w, padded);
}
