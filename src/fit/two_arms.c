/* Pose of one arm's base in that of another: weighted absolute orientation (Horn 1987). */
#include "fit/align.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "math/dense.h"

enum { FREE = 6, SIZE = FREE + 1, MOST_STEPS = 30 };

/* (1 um)^2: lower bound, for simulated arms without noise. */
static const double least_variance = 1e-12;
/* Sockets on one line do not determine the rotation about it.  Smallest ratio of a column's
 * component orthogonal to the others and its length: a lever arm of 1 mm in 1 m. */
static const double least_share = 1e-3;

static double variance_of(const mukca_shared_socket *s)
{
    return fmax(s->variance[0] + s->variance[1], least_variance);
}

/* Residual of a socket and its lever arm for the rotation, both in the left base. */
static void residual(double r[3], double lever[3], const mukca_frame *pose,
                     const mukca_shared_socket *s)
{
    mukca_mat3_vec(lever, pose->R, s->at[1]);
    for (int a = 0; a < 3; a++) r[a] = s->at[0][a] - pose->p[a] - lever[a];
}

/* R[FREE][SIZE]: triangular factor of the weighted equations; translation first, then rotation. */
static void absorb(double *R, const mukca_frame *pose, const mukca_shared_socket *s, int n)
{
    memset(R, 0, FREE * SIZE * sizeof *R);
    for (int i = 0; i < n; i++) {
        double rows[3 * SIZE] = {0}, r[3], lever[3];
        const double w = 1 / sqrt(variance_of(&s[i]));
        residual(r, lever, pose, &s[i]);
        for (int k = 0; k < 3; k++) {
            double *row = rows + k * SIZE;
            row[k] = w;
            row[3 + (k + 1) % 3] = w * lever[(k + 2) % 3];
            row[3 + (k + 2) % 3] = -w * lever[(k + 1) % 3];
            row[FREE] = w * r[k];
        }
        mukca_dense_qr_absorb(R, NULL, rows, 3, FREE, 1);
    }
}

static bool determined(const double *R)
{
    for (int c = 0; c < FREE; c++) {
        double length = 0;
        for (int i = 0; i <= c; i++) length = hypot(length, R[i * SIZE + c]);
        if (!(fabs(R[c * SIZE + c]) > least_share * length)) return false;
    }
    return true;
}

/* 97.5 % quantile of Student's t (Abramowitz and Stegun 26.7.5), to 1 % from 3 degrees of freedom
 * on. */
static double student(int freedom)
{
    const double z = 1.959963985, z2 = z * z, f = freedom;
    return z * (1 + (z2 + 1) / (4 * f) + ((5 * z2 + 16) * z2 + 3) / (96 * f * f) +
                (((3 * z2 + 19) * z2 + 17) * z2 - 15) / (384 * f * f * f));
}

/* Standard errors and intervals of the pose from the factor R of the last step. */
static void judge(mukca_two_arms *out, double *R, const mukca_shared_socket *s, int n)
{
    double chi2 = 0, squares = 0, noise = 0;
    for (int i = 0; i < n; i++) {
        double r[3], lever[3];
        residual(r, lever, &out->pose, &s[i]);
        chi2 += mukca_dot3(r, r) / variance_of(&s[i]);
        squares += mukca_dot3(r, r);
        noise += 3 * variance_of(&s[i]);
    }
    out->freedom = 3 * n - FREE;
    out->residual_m = sqrt(squares / n);
    out->expected_m = sqrt(noise / n * out->freedom / (3 * n));
    out->scale = fmax(1, sqrt(chi2 / out->freedom));
    memset(out->sigma, 0, sizeof out->sigma);
    for (int k = 0; k < FREE; k++) { /* columns of R^-1 */
        double x[FREE];
        for (int i = 0; i < FREE; i++) R[i * SIZE + FREE] = i == k;
        mukca_dense_qr_solve(x, R, FREE);
        for (int i = 0; i < FREE; i++) out->sigma[i] = hypot(out->sigma[i], x[i]);
    }
    for (int i = 0; i < FREE; i++) {
        out->sigma[i] *= out->scale;
        out->width95[i] =
            (out->scale > 1 ? student(out->freedom) : student(1000000)) * out->sigma[i];
    }
}

mukca_status mukca_two_arms_align(mukca_two_arms *out, const mukca_shared_socket *s, int n,
                                  mukca_error *error)
{
    double R[FREE * SIZE];
    if (n < 3)
        return mukca_fail(error, MUKCA_UNIDENTIFIABLE,
                          "the arms share %d sockets; three are needed, not on one line: record "
                          "two placements with both arms",
                          n);
    mukca_frame_nearest(&out->pose, s->at[0], s->at[1], sizeof *s / sizeof(double), n);
    for (int pass = 0; pass < MOST_STEPS; pass++) {
        double x[FREE], turn[9], turned[9], step = 0;
        absorb(R, &out->pose, s, n);
        if (!determined(R))
            return mukca_fail(error, MUKCA_UNIDENTIFIABLE,
                              "the sockets that the arms share lie on one line; record another "
                              "placement off it with both arms");
        mukca_dense_qr_solve(x, R, FREE);
        mukca_rotation_exp(turn, x + 3);
        mukca_mat3_mul(turned, turn, out->pose.R);
        memcpy(out->pose.R, turned, sizeof turned);
        for (int i = 0; i < FREE; i++) {
            if (i < 3) out->pose.p[i] += x[i];
            step = fmax(step, fabs(x[i]));
        }
        if (step < 1e-12) break;
    }
    judge(out, R, s, n);
    return MUKCA_OK;
}
