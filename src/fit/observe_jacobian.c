/* The Jacobian of the residuals, and their weights. */
#include "fit/poses.h"

#include <math.h>
#include <string.h>

/* J rows of one orientation: derivative of the rotation vector w, not of the rotation itself. */
static void turn_rows_of(double *J, int n, const double w[3])
{
    const double angle = mukca_norm3(w);
    const double f = angle < 1e-3
                         ? 1.0 / 12 + angle * angle / 720
                         : 1 / (angle * angle) - (1 + cos(angle)) / (2 * angle * sin(angle));
    double M[9];
    for (int r = 0; r < 3; r++) /* I - [w]x / 2 + f [w]x^2 */
        for (int c = 0; c < 3; c++)
            M[3 * r + c] = (r == c) * (1 - f * angle * angle) + f * w[r] * w[c];
    M[1] += w[2] / 2, M[2] -= w[1] / 2, M[3] -= w[2] / 2;
    M[5] += w[0] / 2, M[6] += w[1] / 2, M[7] -= w[0] / 2;
    for (int i = 0; i < n; i++) {
        double v[3] = {J[i], J[n + i], J[2 * n + i]}, u[3];
        mukca_mat3_vec(u, M, v);
        for (int a = 0; a < 3; a++) J[a * n + i] = MUKCA_METRES_PER_RADIAN * u[a];
    }
}

/* Rows of one sample: subtract the mean of its socket, convert rotations to rotation vectors. */
static void finish_rows(double *J, double *JO, const mukca_observations *o, int n, int row)
{
    const double *mean = o->mean_rows + 3L * o->socket[row] * n;
    if (o->socket[row] >= 0)
        for (int c = 0; c < 3 * n; c++) J[c] -= mean[c];
    if (!(o->share[row] > 0)) memset(J, 0, 3 * (size_t)n * sizeof *J);
    if (!JO) return;
    const mukca_sweep *s = &o->sweep;
    const double *turned = mukca_observe_window(o->turn_residual, s) + row - s->from;
    double w[3];
    for (int a = 0; a < 3; a++) w[a] = turned[a * s->padded] / MUKCA_METRES_PER_RADIAN;
    if (o->turn_share[row] > 0)
        turn_rows_of(JO, n, w);
    else
        memset(JO, 0, 3 * (size_t)n * sizeof *JO);
}

static void jacobian_of(double *J, mukca_observations *o, const double *theta,
                        const mukca_parameters *parameters, mukca_gradient kind)
{
    const long n = parameters->n;
    mukca_sweep *sweep = &o->sweep;
    double *JO = o->turn_share ? J + 3 * o->n_rows * n : NULL;
    for (int v = 0; v < sweep->n_windows; v++) {
        mukca_sweep_open(sweep, v);
        if (sweep->n_windows > 1) mukca_sweep_forward(sweep); /* else still valid */
        const long at = 3 * sweep->from * n;
        mukca_sweep_jacobian(J + at, JO ? JO + at : NULL, sweep, theta, parameters, kind);
    }
    memset(o->mean_rows, 0, 3 * (size_t)(o->n_sockets * n) * sizeof *o->mean_rows);
    for (int i = 0; i < o->n_rows; i++) {
        if (o->socket[i] < 0) continue;
        double *mean = o->mean_rows + 3 * o->socket[i] * n;
        for (int c = 0; c < 3 * n; c++) mean[c] += J[3 * i * n + c];
    }
    for (int s = 0; s < o->n_sockets; s++)
        for (int c = 0; c < 3 * n && o->count[s] > 0; c++)
            o->mean_rows[3 * s * n + c] /= o->count[s];
    for (int v = 0; v < sweep->n_windows; v++) {
        mukca_sweep_open(sweep, v);
        for (int i = sweep->from; i < sweep->from + sweep->rows; i++)
            finish_rows(J + 3 * i * n, JO ? JO + 3 * i * n : NULL, o, parameters->n, i);
    }
    double *row = J + (o->turn_share ? 6 : 3) * o->n_rows * n;
    for (int p = 0; p < o->n_pairs; p++, row += n) {
        const double *a = o->mean_rows + 3 * o->pair[2 * p] * n;
        const double *b = o->mean_rows + 3 * o->pair[2 * p + 1] * n;
        const double *u = o->pair_direction + 3 * p;
        for (int c = 0; c < n; c++)
            row[c] = u[0] * (a[c] - b[c]) + u[1] * (a[n + c] - b[n + c]) +
                     u[2] * (a[2 * n + c] - b[2 * n + c]);
    }
}

void mukca_observe_residuals(double *r, double *J, mukca_observations *o, const double *theta,
                             const mukca_parameters *parameters, mukca_gradient kind)
{
    const int n = o->n_rows;
    mukca_sweep *s = &o->sweep;
    mukca_observe_predict(o, theta);
    mukca_orientations_predict(o);
    for (int v = 0; v < s->n_windows; v++) {
        mukca_sweep_open(s, v);
        const double *residual = mukca_observe_window(o->residual, s);
        for (int i = 0; i < s->rows; i++)
            for (int a = 0; a < 3; a++) r[3 * (s->from + i) + a] = residual[a * s->padded + i];
        residual = o->turn_share ? mukca_observe_window(o->turn_residual, s) : NULL;
        for (int i = 0; i < s->rows && residual; i++)
            for (int a = 0; a < 3; a++) r[3 * (n + s->from + i) + a] = residual[a * s->padded + i];
    }
    memcpy(r + (o->turn_share ? 6 : 3) * n, o->pair_residual,
           (size_t)o->n_pairs * sizeof *o->pair_residual);
    if (J) jacobian_of(J, o, theta, parameters, kind);
}

void mukca_observe_weights(double *weight, const mukca_observations *o)
{
    for (int i = 0; i < o->n_rows; i++)
        for (int a = 0; a < 3; a++) {
            weight[3 * i + a] = sqrt(o->share[i]);
            if (o->turn_share) weight[3 * (o->n_rows + i) + a] = sqrt(o->turn_share[i]);
        }
    for (int p = 0; p < o->n_pairs; p++) weight[(o->turn_share ? 6 : 3) * o->n_rows + p] = 1;
}
