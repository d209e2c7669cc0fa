/* The rotation nearest to a matrix, and the pose that brings points to points. */
#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "mukca/rotation.h"

void mukca_rotation_nearest(double R[9], const double H[9])
{
    double U[9], s[3], V[9], u[3][3], v[3][3]; /* columns of U and V */
    memcpy(U, H, sizeof U);
    if (mukca_dense_svd(U, s, V, 3) || !(s[1] > 1e-9 * s[0])) return;
    for (int c = 0; c < 2; c++)
        for (int i = 0; i < 3; i++) u[c][i] = U[3 * i + c], v[c][i] = V[3 * i + c];
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

double mukca_frame_refine(double R[MUKCA_MEETING_FACTOR], mukca_frame *base, double tool[3],
                          const mukca_meeting *m)
{
    enum { N = MUKCA_MEETING, SIZE = N + 1 };
    double x[N], turn[9], turned[9], largest = 0;
    memset(R, 0, MUKCA_MEETING_FACTOR * sizeof *R);
    for (int i = 0; i < m->n; i++) {
        const mukca_meeting_point *p = &m->points[i];
        const double w = sqrt(p->weight);
        double rows[3 * SIZE] = {0}, at[3], lever[3], RF[9];
        mukca_mat3_vec(at, p->from.R, tool);
        for (int k = 0; k < 3; k++) at[k] += p->from.p[k];
        mukca_mat3_vec(lever, base->R, at);
        mukca_mat3_mul(RF, base->R, p->from.R);
        for (int k = 0; k < 3; k++) {
            double *row = rows + k * SIZE;
            if (m->base) {
                row[k] = w;
                row[3 + (k + 1) % 3] = w * lever[(k + 2) % 3]; /* omega x lever */
                row[3 + (k + 2) % 3] = -w * lever[(k + 1) % 3];
            }
            for (int c = 0; c < 3 && m->tool; c++) row[6 + c] = w * RF[3 * k + c];
            row[N] = w * (p->to[k] - base->p[k] - lever[k]);
        }
        mukca_dense_qr_absorb(R, NULL, rows, 3, N, 1);
    }
    for (int c = 0; c < N; c++) {
        double row[SIZE] = {0};
        row[c] = c < 6 ? 1e-6 : m->pull;
        row[N] = c < 6 ? 0 : -m->pull * tool[c - 6];
        mukca_dense_qr_absorb(R, NULL, row, 1, N, 1);
    }
    mukca_dense_qr_solve(x, R, N);
    for (int i = 0; i < N; i++) {
        if (!isfinite(x[i])) return 0;
        largest = fmax(largest, fabs(x[i]));
    }
    mukca_rotation_exp(turn, x + 3);
    mukca_mat3_mul(turned, turn, base->R);
    memcpy(base->R, turned, sizeof turned);
    for (int k = 0; k < 3; k++) base->p[k] += x[k], tool[k] += x[6 + k];
    return largest;
}
