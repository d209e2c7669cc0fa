/* The rotation nearest to a matrix, and the pose that brings points to points. */
#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "mukca/rotation.h"

void mukca_rotation_turn(double R[9], const double w[3], bool own_axes)
{
    double turn[9], turned[9];
    mukca_rotation_exp(turn, w);
    mukca_mat3_mul(turned, own_axes ? R : turn, own_axes ? turn : R);
    memcpy(R, turned, sizeof turned);
}

/* Turn R by the least angle that takes R u to v; u and v are unit vectors. */
static void turn_onto(double R[9], const double u[3], const double v[3])
{
    double w[3], axis[3], other[3];
    mukca_mat3_vec(w, R, u);
    mukca_cross(axis, w, v);
    const double sine = mukca_norm3(axis), angle = atan2(sine, mukca_dot3(w, v));
    if (sine > 1e-9)
        for (int i = 0; i < 3; i++) axis[i] /= sine;
    else /* the same, or opposite: any axis */
        mukca_rotation_transverse(axis, other, w);
    for (int i = 0; i < 3; i++) axis[i] *= angle;
    mukca_rotation_turn(R, axis, false);
}

void mukca_rotation_nearest(double R[9], const double H[9])
{
    double U[9], s[3], V[9], u[3][3], v[3][3]; /* columns of U and V */
    memcpy(U, H, sizeof U);
    if (!mukca_dense_svd(U, s, V, 3) || !(s[0] > 0)) return;
    for (int c = 0; c < 2; c++)
        for (int i = 0; i < 3; i++) u[c][i] = U[3 * i + c], v[c][i] = V[3 * i + c];
    if (!(s[1] > 1e-9 * s[0])) {
        turn_onto(R, u[0], v[0]);
        return;
    }
    mukca_cross(u[2], u[0], u[1]); /* for det R = 1 */
    mukca_cross(v[2], v[0], v[1]);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            R[3 * i + j] = v[0][i] * u[0][j] + v[1][i] * u[1][j] + v[2][i] * u[2][j];
}

void mukca_frame_nearest(mukca_frame *pose, const double *to, const double *from, int stride, int n)
{
    double mean[2][3] = {{0}}, H[9] = {0}, turned[3];
    for (int i = 0; i < n * stride; i += stride)
        for (int r = 0; r < 3; r++) mean[0][r] += to[i + r] / n, mean[1][r] += from[i + r] / n;
    for (int i = 0; i < n * stride; i += stride)
        for (int r = 0; r < 9; r++)
            H[r] += (from[i + r / 3] - mean[1][r / 3]) * (to[i + r % 3] - mean[0][r % 3]);
    *pose = (mukca_frame){.R = MUKCA_IDENTITY};
    mukca_rotation_nearest(pose->R, H);
    mukca_mat3_vec(turned, pose->R, mean[1]);
    for (int r = 0; r < 3; r++) pose->p[r] = mean[0][r] - turned[r];
}

enum { MEETING_ROW = MUKCA_MEETING + 1 };

/* Equations of one point: position, then orientation. */
static void meeting_rows(double rows[6 * MEETING_ROW], const mukca_frame *base,
                         const mukca_frame *tool, const mukca_meeting *m,
                         const mukca_meeting_point *p)
{
    const double w = sqrt(p->weight), v = isnan(p->turned[0]) ? 0 : w * m->per_radian;
    double at[3], lever[3], BF[9], BFT[9], off[3] = {0};
    mukca_frame_point(at, &p->from, tool->p);
    mukca_mat3_vec(lever, base->R, at);
    mukca_mat3_mul(BF, base->R, p->from.R);
    mukca_mat3_mul(BFT, BF, tool->R);
    if (v > 0) mukca_rotation_difference(off, p->turned, BFT);
    memset(rows, 0, 6 * MEETING_ROW * sizeof *rows);
    for (int k = 0; k < 3; k++) {
        double *row = rows + k * MEETING_ROW, *turn = row + 3 * MEETING_ROW;
        if (m->base) {
            row[k] = w;
            row[3 + (k + 1) % 3] = w * lever[(k + 2) % 3]; /* omega x lever */
            row[3 + (k + 2) % 3] = -w * lever[(k + 1) % 3];
            turn[3 + k] = v;
        }
        for (int c = 0; c < 3 && m->tool; c++) {
            row[6 + c] = w * BF[3 * k + c];
            turn[9 + c] = v * BFT[3 * k + c];
        }
        row[MUKCA_MEETING] = w * (p->to[k] - base->p[k] - lever[k]);
        turn[MUKCA_MEETING] = v * off[k];
    }
}

double mukca_frame_refine(double R[MUKCA_MEETING_FACTOR], mukca_frame *base, mukca_frame *tool,
                          const mukca_meeting *m)
{
    enum { N = MUKCA_MEETING };
    double x[N], largest = 0;
    memset(R, 0, MUKCA_MEETING_FACTOR * sizeof *R);
    for (int i = 0; i < m->n; i++) {
        double rows[6 * MEETING_ROW];
        meeting_rows(rows, base, tool, m, &m->points[i]);
        mukca_dense_qr_absorb(R, rows, m->per_radian > 0 ? 6 : 3, N, 1);
    }
    for (int c = 0; c < N; c++) {
        const bool place = c >= 6 && c < 9;
        double row[MEETING_ROW] = {0};
        row[c] = fmax(m->damping, 1e-6);
        mukca_dense_qr_absorb(R, row, 1, N, 1);
        if (!place) continue;
        row[c] = m->pull;
        row[N] = -m->pull * tool->p[c - 6];
        mukca_dense_qr_absorb(R, row, 1, N, 1);
    }
    mukca_dense_qr_solve(x, R, N);
    for (int i = 0; i < N; i++) {
        if (!isfinite(x[i])) return 0;
        largest = fmax(largest, fabs(x[i]));
    }
    mukca_rotation_turn(base->R, x + 3, false);
    mukca_rotation_turn(tool->R, x + 9, true);
    for (int k = 0; k < 3; k++) base->p[k] += x[k], tool->p[k] += x[6 + k];
    return largest;
}

void mukca_meeting_errors(double *sigma, double *R, int n)
{
    memset(sigma, 0, (size_t)n * sizeof *sigma);
    for (int k = 0; k < n; k++) { /* columns of R^-1 */
        double x[MUKCA_MEETING];
        for (int i = 0; i < MUKCA_MEETING; i++) R[i * (MUKCA_MEETING + 1) + MUKCA_MEETING] = i == k;
        mukca_dense_qr_solve(x, R, MUKCA_MEETING);
        for (int i = 0; i < n; i++) sigma[i] = hypot(sigma[i], x[i]);
    }
}
