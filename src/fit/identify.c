/* Identifiability of the parameters and their standard errors. */
#include "fit/fit.h"

#include <math.h>
#include <string.h>

#include "fit/poses.h"
#include "fit/solver.h"
#include "math/dense.h"

/* Relative tolerance of the rank: smaller singular values, relative to the largest, count as zero.
 */
static const double rank_tolerance = 1e-7;

/* A parameter is identifiable if its component in every unit vector of the null space is below
 * this: moving 10 mm or mrad along the null space changes the parameter by less than 10 um or
 * urad. */
static const double hidden_share = 1e-3;

/* Fraction of a socket's samples, or of the poses (-1), that is in the part. */
static double share_in_part(const mukca_cost *cost, int socket)
{
    const mukca_observations *all = &cost->observations, *part = &cost->part->observations;
    if (cost->part == cost) return 1;
    if (socket >= 0) return part->count[socket] / all->count[socket];
    double poses = part->n_rows, whole = all->n_rows;
    for (int s = 0; s < all->n_sockets; s++) poses -= part->count[s], whole -= all->count[s];
    return poses / whole;
}

/* B[n][n] = covariance of J'W r for unit noise of every coordinate of all samples: each sample acts
 * on its own residual and, through the mean of its socket, on the distances.  Overwrites the
 * weighted Jacobian. */
static void score_covariance(double *B, mukca_cost *cost)
{
    mukca_cost *part = cost->part;
    mukca_observations *o = &part->observations;
    const int n = cost->n, rows = o->n_rows, first_pair = o->n_residuals - o->n_pairs;
    for (int i = 0; i < first_pair; i++) {
        const double f = part->weight[i] * sqrt(share_in_part(cost, o->socket[i / 3 % rows]));
        for (int c = 0; c < n; c++) part->J[i * n + c] *= f;
    }
    for (int i = 0; i < rows; i++)
        for (int p = 0; p < o->n_pairs; p++) {
            const int s = o->socket[i];
            const int sign = (o->pair[p].a == s) - (o->pair[p].b == s);
            if (s < 0 || sign == 0) continue;
            const double weight = sqrt(share_in_part(cost, s));
            for (int a = 0; a < 3; a++) {
                const double f = weight * sign * o->pair[p].direction[a] / o->count[s];
                for (int c = 0; c < n; c++)
                    part->J[(3 * i + a) * n + c] += f * part->J[(first_pair + p) * n + c];
            }
        }
    memset(B, 0, (size_t)(n * n) * sizeof *B);
    mukca_dense_syrk(B, n, part->J, first_pair, n);
}

/* R[n + 3][n + 3]: triangular factor of the weighted Jacobian in part->J, augmented by the
 * derivatives of the residuals with respect to rotations of the whole arm about x, y, z. */
static void factorise(double *R, const mukca_cost *part)
{
    const mukca_observations *o = &part->observations;
    const int n = part->n;
    double row[MUKCA_MAX_FREE + 3];
    memset(R, 0, (size_t)((n + 3) * (n + 3)) * sizeof *R);
    for (int i = 0; i < o->n_residuals; i++) {
        const int first = i - i % 3, y = (i + 1) % 3, z = (i + 2) % 3;
        const bool turns = i < 3 * o->n_rows; /* else a distance */
        memcpy(row, part->J + i * n, (size_t)n * sizeof *row);
        row[n + i % 3] = 0;
        row[n + y] = turns ? part->weight[i] * part->r[first + z] : 0;
        row[n + z] = turns ? -part->weight[i] * part->r[first + y] : 0;
        mukca_dense_qr_absorb(R, row, 1, n + 3, 0);
    }
}

/* A rotation of the whole arm rotates all residuals without a change of the cost: data of sockets
 * do not identify it, although the residuals change to first order.  If the free parameters can
 * rotate the arm, project this rotation out of the factor of the Jacobian, R[n + 3][n + 3];
 * X[n][n + 3], initially 0, is scratch. */
static void project_out_turning(double *R, double *X, int n)
{
    const int wide = n + 3;
    double T[9], s[3], V[9], size = 0, square[3] = {0};
    for (int r = 0; r < wide; r++) size += mukca_dot3(R + r * wide + n, R + r * wide + n);
    for (int i = 0; i < 9; i++) T[i] = R[(n + i / 3) * wide + n + i % 3];
    if (!mukca_dense_svd(T, s, V, 3)) return;
    for (int c = 0; c < 3; c++) /* else the parameters cannot rotate the arm */
        for (int i = 0; i < n && s[c] <= 1e-6 * sqrt(size); i++) {
            for (int a = 0; a < 3; a++) X[i * wide + c] += R[i * wide + n + a] * V[3 * a + c];
            square[c] += X[i * wide + c] * X[i * wide + c];
        }
    for (int i = 0; i < n; i++) {
        for (int c = 0; c < 3; c++) X[i * wide + c] /= square[c] > 0 ? sqrt(square[c]) : 1;
        memcpy(X + i * wide + 3, R + i * wide, (size_t)n * sizeof *X);
    }
    mukca_dense_project(X, n, wide, 0, 3);
    for (int i = 0; i < n; i++) memcpy(R + i * wide, X + i * wide + 3, (size_t)n * sizeof *R);
}

/* Standard errors diag(G B G)^(1/2) with the pseudo-inverse G = V S^-2 V'; `row` [n] is scratch. */
static void standard_errors(mukca_identification *id, const double *V, const double *s,
                            const double *B, double *row, int n)
{
    for (int i = 0; i < n; i++) {
        double hidden = 0, variance = 0;
        for (int r = id->rank; r < n; r++) hidden += V[i * n + r] * V[i * n + r];
        for (int j = 0; j < n; j++) {
            row[j] = 0;
            for (int r = 0; r < id->rank; r++)
                row[j] += V[i * n + r] * V[j * n + r] / (s[r] * s[r]);
        }
        for (int j = 0; j < n; j++)
            for (int k = 0; k < n; k++) variance += row[j] * B[j * n + k] * row[k];
        id->identifiable[i] = hidden < hidden_share * hidden_share;
        id->sigma[i] = id->identifiable[i] ? id->noise * sqrt(fmax(variance, 0)) : HUGE_VAL;
    }
}

mukca_status mukca_identify(mukca_identification *id, mukca_cost *cost, const double *x,
                            mukca_pool *pool, mukca_error *error)
{
    const int n = cost->n;
    mukca_observations *o = &cost->observations;
    double *B = MUKCA_TAKE(pool, double, n *n), *R = MUKCA_TAKE(pool, double, (n + 3) * (n + 3)),
           *V = MUKCA_TAKE(pool, double, n *n), *s = MUKCA_TAKE(pool, double, n),
           *X = MUKCA_TAKE(pool, double, n *(n + 3));
    double log_product = 0, distances;
    memset(id, 0, sizeof *id);
    if (pool->failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d parameters", n);
    mukca_cost_normal(R, cost, x, true);
    if (cost->part != cost) {
        mukca_observe_predict(o, cost->part->theta);
        mukca_orientations_predict(o);
    }
    double squares =
        mukca_observe_squares(&distances, o, false) + mukca_orientations_squares(o, false);
    squares += distances;
    factorise(R, cost->part);
    score_covariance(B, cost);                    /* overwrites the Jacobian */
    if (!o->target) project_out_turning(R, X, n); /* measured poses identify that rotation */
    for (int i = 1; i < n; i++) memmove(R + i * n, R + i * (n + 3), (size_t)n * sizeof *R);
    if (!mukca_dense_svd(R, s, V, n))
        return mukca_fail(error, MUKCA_INPUT, "the model's derivatives are not finite numbers");
    while (id->rank < n && s[id->rank] > rank_tolerance * s[0]) log_product += log(s[id->rank++]);
    id->observability = id->rank > 0 ? exp(log_product / id->rank) : 0;
    const int spare = o->n_measured - id->rank;
    id->noise = spare > 0 ? sqrt(squares / spare) : HUGE_VAL;
    standard_errors(id, V, s, B, R, n);
    return MUKCA_OK;
}
