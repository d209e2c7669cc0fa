/* Least squares for re-calibration, row by row. */
#include "recalibrate/recalibrate.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"

void mukca_pose_system_clear(mukca_pose_system *s)
{
    s->equations = 0;
    memset(s->filled, 0, sizeof s->filled);
    s->rss = 0;
    memset(s->R, 0, sizeof *s->R * (size_t)(s->n * (s->n + 1)));
}

static void absorb_block(mukca_pose_system *s, int kind)
{
    mukca_dense_qr_absorb(s->R, &s->rss, s->block[kind], s->filled[kind], s->n, 1);
    s->filled[kind] = 0;
}

static void absorb_all(mukca_pose_system *s)
{
    for (int kind = 0; kind < 2; kind++) absorb_block(s, kind);
}

/* Allocate three more rows of positions (0) or rotations (1). */
static double *three_rows(mukca_pose_system *s, int kind)
{
    if (s->filled[kind] + 3 > MUKCA_SYSTEM_BLOCK) absorb_block(s, kind);
    s->filled[kind] += 3;
    return s->block[kind] + (s->filled[kind] - 3) * (s->n + 1);
}

/* Set the right-hand side of three rows and apply the weight. */
static void finish_rows(mukca_pose_system *s, double *rows, const double *residual, double weight)
{
    const int width = s->n + 1;
    for (int i = 0; i < 3; i++) {
        double *row = rows + i * width;
        row[width - 1] = residual[i];
        for (int c = 0; c < width && weight != 1; c++) row[c] *= weight;
    }
    s->equations += 3;
}

void mukca_pose_system_add(mukca_pose_system *s, const mukca_pose_look *look, double weight,
                           double turn_weight)
{
    const bool rotations = s->rotations && isfinite(look->rotation[0]);
    const double lever = s->metres_per_radian > 0 ? s->metres_per_radian : 1;
    double *p = s->positions ? three_rows(s, 0) : NULL, *w = rotations ? three_rows(s, 1) : NULL;
    mukca_pose_derivatives(p, w, s->n + 1, look, s->unknown, s->n);
    if (p) finish_rows(s, p, look->position, weight);
    if (w) finish_rows(s, w, look->rotation, turn_weight * lever);
}

/* Ratio of prior sizes, tool to arm.  Combinations of both that the data do not determine are
 * assigned to the tool, in agreement with calibrate, which does not regularise the tool.  A ratio
 * of 1e3 assigns 1e-6 of them to the arm. */
static const double tool_freedom = 1e3;

/* Replace the solutions in the first `rank` columns of V[n][n] by the equivalent ones of least norm
 * in units of the prior sizes: in these units orthogonal to the null directions, the other columns.
 */
static void prefer_tool(double *V, double *A, const mukca_pose_system *s, int n, int rank)
{
    double weight[MUKCA_MAX_UNKNOWNS];
    for (int i = 0; i < n; i++) {
        weight[i] = s->unknown[i].tool ? 1 / tool_freedom : 1;
        for (int k = 0; k < n; k++) A[i * n + k] = weight[i] * V[i * n + (k + rank) % n];
    }
    mukca_dense_project(A, n, n, 0, n - rank);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < rank; k++) V[i * n + k] = A[i * n + n - rank + k] / weight[i];
}

bool mukca_pose_system_solve(mukca_pose_estimates *to, mukca_pose_system *s, int n, double loosest)
{
    const int width = s->n + 1;
    double d[MUKCA_MAX_UNKNOWNS], singular[MUKCA_MAX_UNKNOWNS];
    double *U = s->U, *V = s->V, *sigma = to->sigma + to->n, (*null)[MUKCA_MAX_UNKNOWNS];
    int rank = 0;
    absorb_all(s);
    memset(s->x, 0, sizeof s->x);
    double left = s->rss; /* includes the square explained by the unknowns from n on */
    for (int i = n; i < s->n; i++)
        left += s->R[i * width + width - 1] * s->R[i * width + width - 1];
    for (int i = 0; i < n; i++) {
        memcpy(U + i * n, s->R + i * width, (size_t)n * sizeof *U);
        d[i] = s->R[i * width + width - 1];
        sigma[i] = 0;
    }
    if (n == 0) return true;
    if (mukca_dense_svd(U, singular, V, n) || !isfinite(left)) return false;
    const long freedom = s->equations - n;
    const double noise = sqrt(left / (double)(freedom > 0 ? freedom : 1));
    const double least = fmax(1e-9 * singular[0], noise / loosest);
    while (rank < n && singular[rank] > least) rank++;
    const int n_null = n - rank;
    null = to->null + to->n_null;
    for (int k = 0; k < n_null; k++) memset(null[k], 0, sizeof null[k]);
    prefer_tool(V, s->A, s, n, rank);
    for (int k = 0; k < n; k++) {
        double z = 0;
        for (int i = 0; i < n; i++) z += U[i * n + k] * d[i];
        for (int i = 0; i < n; i++) {
            if (k < rank) {
                const double v = V[i * n + k] / singular[k];
                s->x[i] += v * z;
                sigma[i] += v * v;
            } else {
                null[k - rank][to->n + i] = V[i * n + k];
            }
        }
        if (k >= rank) left += z * z;
    }
    const double variance = left / (double)(freedom > 0 ? freedom + n_null : 1);
    for (int i = 0; i < n; i++) {
        double lost = 0;
        for (int k = 0; k < n_null; k++) lost += null[k][to->n + i] * null[k][to->n + i];
        sigma[i] = sqrt(sigma[i] * variance);
        to->identifiable[to->n + i] = lost < 1e-8;
        to->unknown[to->n + i] = s->unknown[i];
    }
    mukca_dense_reduce(null[0] + to->n, n_null, n, MUKCA_MAX_UNKNOWNS);
    const int lag = s->unknown[n - 1].kind == MUKCA_UNKNOWN_LAG;
    for (int k = 0; k < n_null; k++)
        for (int c = 0; c < n; c++)
            if (fabs(null[k][to->n + c]) < 1e-6 || c + lag == n) null[k][to->n + c] = 0;
    to->n_null += n_null;
    to->rank += rank;
    to->n += n - lag;
    return true;
}

double mukca_pose_system_last(mukca_pose_system *s)
{
    absorb_all(s);
    const int n = s->n, width = n + 1;
    const long freedom = s->equations - n;
    const double sigma = sqrt(s->rss / (double)(freedom > 0 ? freedom : 1)),
                 known = fabs(s->R[(n - 1) * width + n - 1]), rhs = fabs(s->R[n * width - 1]);
    return known > 1e-9 && sigma > 0 ? rhs / sigma : 0;
}
