/* Pose of one arm's base in that of another: weighted absolute orientation (Horn 1987). */
#include <math.h>
#include <string.h>

#include "base/pool.h"
#include "fit/align.h"
#include "math/dense.h"
#include "math/stats.h"

enum { MOST_STEPS = 30, FREE = 6, SIZE = MUKCA_MEETING + 1 };

/* (1 um)^2: lower bound, for simulated arms without noise. */
static const double least_variance = 1e-12;
/* Sockets on one line do not determine the rotation about it.  Smallest ratio of a column's
 * component orthogonal to the others and its length: a lever arm of 1 mm in 1 m. */
static const double least_share = 1e-3;

static double variance_of(const mukca_shared_socket *s)
{
    return fmax(s->variance[0] + s->variance[1], least_variance);
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
    const double z = MUKCA_SIGMAS_95, z2 = z * z, f = freedom;
    return z * (1 + (z2 + 1) / (4 * f) + ((5 * z2 + 16) * z2 + 3) / (96 * f * f) +
                (((3 * z2 + 19) * z2 + 17) * z2 - 15) / (384 * f * f * f));
}

/* Standard errors and intervals of the pose from the factor R of the last step. */
static void judge(mukca_two_arms *out, double *R, const mukca_shared_socket *s, int n)
{
    double chi2 = 0, squares = 0, noise = 0;
    for (int i = 0; i < n; i++) {
        double r[3], at[3];
        mukca_mat3_vec(at, out->pose.R, s[i].at[1]);
        for (int a = 0; a < 3; a++) r[a] = s[i].at[0][a] - out->pose.p[a] - at[a];
        chi2 += mukca_dot3(r, r) / variance_of(&s[i]);
        squares += mukca_dot3(r, r);
        noise += 3 * variance_of(&s[i]);
    }
    out->freedom = 3 * n - FREE;
    out->residual_m = sqrt(squares / n);
    out->expected_m = sqrt(noise / n * out->freedom / (3 * n));
    out->scale = fmax(1, sqrt(chi2 / out->freedom));
    mukca_meeting_errors(out->sigma, R, FREE);
    for (int i = 0; i < FREE; i++) {
        out->sigma[i] *= out->scale;
        out->width95[i] =
            (out->scale > 1 ? student(out->freedom) : student(1000000)) * out->sigma[i];
    }
}

mukca_status mukca_two_arms_align(mukca_two_arms *out, const mukca_shared_socket *s, int n,
                                  mukca_error *error)
{
    double R[MUKCA_MEETING_FACTOR];
    mukca_frame none = {.R = MUKCA_IDENTITY};
    if (n < 3)
        return mukca_fail(error, MUKCA_UNIDENTIFIABLE,
                          "the arms share %d sockets; three are needed, not on one line: record "
                          "two placements with both arms",
                          n);
    mukca_pool pool = {0};
    mukca_meeting_point *points = MUKCA_TAKE(&pool, mukca_meeting_point, n);
    if (!points) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    const mukca_meeting meeting = {.points = points, .n = n, .base = true};
    for (int i = 0; i < n; i++) {
        points[i].weight = 1 / variance_of(&s[i]);
        memcpy(points[i].to, s[i].at[0], sizeof points[i].to);
        memcpy(points[i].from.p, s[i].at[1], sizeof points[i].from.p);
    }
    mukca_frame_nearest(&out->pose, s->at[0], s->at[1], sizeof *s / sizeof(double), n);
    for (int pass = 0; pass < MOST_STEPS; pass++)
        if (mukca_frame_refine(R, &out->pose, &none, &meeting) < 1e-12) break;
    mukca_pool_free(&pool);
    if (!determined(R))
        return mukca_fail(error, MUKCA_UNIDENTIFIABLE,
                          "the sockets that the arms share lie on one line; record another "
                          "placement off it with both arms");
    judge(out, R, s, n);
    return MUKCA_OK;
}
