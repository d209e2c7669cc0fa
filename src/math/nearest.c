/* The rotation nearest to a matrix. */
#include <string.h>

#include "math/dense.h"
#include "mukca/rotation.h"

void mukca_rotation_nearest(double R[9], const double H[9])
{
    double U[9], s[3], V[9], u[3][3], v[3][3]; /* columns of U and V */
    memcpy(U, H, sizeof U);
    if (mukca_dense_svd(U, s, V, 3, 3) || !(s[1] > 1e-9 * s[0])) return;
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
    *pose = (mukca_frame){.R = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    mukca_rotation_nearest(pose->R, H);
    mukca_mat3_vec(turned, pose->R, mean[1]);
    for (int r = 0; r < 3; r++) pose->p[r] = mean[0][r] - turned[r];
}
