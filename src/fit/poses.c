/* Measured poses; residuals and gradient of orientations. */
#include "fit/poses.h"

#include <math.h>
#include <string.h>

static bool has_position(const mukca_dataset *data, int row)
{
    return data->socket[row] < 0 && data->position && isfinite(data->position[3 * row]);
}

static bool has_orientation(const mukca_dataset *data, int row)
{
    return data->socket[row] < 0 && data->quaternion && isfinite(data->quaternion[4 * row]);
}

static bool take(mukca_observations *o, mukca_pool *pool, bool oriented)
{
    const int n = o->n_rows;
    o->target = MUKCA_TAKE(pool, double, 3 * n);
    if (!oriented) return !pool->failed;
    o->turn_share = MUKCA_TAKE(pool, double, n);
    o->aim = MUKCA_TAKE(pool, double, 9 * n);
    o->turn_residual = MUKCA_TAKE(pool, double, 3 * (n + MUKCA_SWEEP_PADDING));
    o->n_residuals += 3 * n;
    return !pool->failed;
}

bool mukca_poses_add(mukca_observations *o, mukca_pool *pool, const mukca_dataset *data)
{
    int rows = 0, poses = 0, oriented = 0;
    for (int i = 0; i < o->n_rows; i++) {
        rows += data->socket[i] < 0;
        poses += has_position(data, i) || has_orientation(data, i);
        oriented += has_orientation(data, i);
    }
    if (rows == 0) return true;
    if (!take(o, pool, oriented > 0)) return false;
    o->n_groups += poses > 0;
    o->n_measured += 3 * oriented;
    for (int i = 0; i < o->n_rows; i++) {
        if (has_position(data, i)) {
            o->share[i] = 1.0 / poses;
            o->n_measured += 3;
            memcpy(o->target + 3 * i, data->position + 3 * i, 3 * sizeof *o->target);
        }
        if (has_orientation(data, i)) {
            o->turn_share[i] = 1.0 / poses;
            mukca_rotation_from_quaternion(o->aim + 9 * i, data->quaternion + 4 * i);
        }
    }
    return true;
}

/* For the open window. */
static void predict_window(mukca_observations *o)
{
    const mukca_sweep *s = &o->sweep;
    double *residual = mukca_observe_window(o->turn_residual, s);
    mukca_sweep_orientations(&o->sweep);
    for (int i = 0; i < s->rows; i++) {
        double R[9], off[9], w[3] = {0, 0, 0};
        for (int c = 0; c < 9; c++) R[c] = s->Q[c * s->padded + i];
        for (int r = 0; r < 3; r++) /* predicted times measured transposed */
            for (int c = 0; c < 3; c++)
                off[3 * r + c] = mukca_dot3(R + 3 * r, o->aim + 9 * (s->from + i) + 3 * c);
        if (o->turn_share[s->from + i] > 0) mukca_rotation_log(w, off);
        for (int a = 0; a < 3; a++) residual[a * s->padded + i] = MUKCA_METRES_PER_RADIAN * w[a];
    }
}

void mukca_orientations_predict(mukca_observations *o)
{
    for (int v = 0; v < o->sweep.n_windows && o->turn_share; v++) {
        mukca_sweep_open(&o->sweep, v);
        predict_window(o);
    }
}

double mukca_orientations_squares(mukca_observations *o, bool weighted)
{
    if (!o->turn_share) return 0;
    return mukca_observe_sum(o, o->turn_residual, weighted ? o->turn_share : NULL);
}

/* Adjoints in the open window, summed by element. */
static void add_window(mukca_adjoint *adjoint, mukca_observations *o)
{
    mukca_sweep *s = &o->sweep;
    const double *residual = mukca_observe_window(o->turn_residual, s);
    double *h = s->x;
    memset(h, 0, 3 * (size_t)s->padded * sizeof *h);
    for (int i = 0; i < s->rows; i++)
        for (int a = 0; a < 3; a++)
            h[a * s->padded + i] = 2 * o->turn_share[s->from + i] * MUKCA_METRES_PER_RADIAN *
                                   residual[a * s->padded + i];
    mukca_sweep_backward(adjoint, h, s);
}

void mukca_orientations_gradient(double *gradient, mukca_observations *o, const double *theta,
                                 const mukca_parameters *parameters, mukca_gradient kind)
{
    mukca_adjoint adjoint = {0};
    if (!o->turn_share) return;
    for (int v = 0; v < o->sweep.n_windows; v++) {
        mukca_sweep_open(&o->sweep, v);
        add_window(&adjoint, o);
    }
    for (int i = 0, element = -1; i < parameters->n; i++) {
        const int k = parameters->index[i] / MUKCA_PARAMETERS;
        const int parameter = parameters->index[i] % MUKCA_PARAMETERS;
        double dR[3][9], R[9], omega[3];
        if (parameter < 3) continue;
        if (k != element) {
            mukca_sweep_element_derivative(dR, theta + 6 * k + 3, kind);
            mukca_rotation_from_rpy(R, theta + 6 * k + 3);
        }
        element = k;
        mukca_sweep_spin(omega, dR[parameter - 3], R);
        gradient[i] += mukca_dot3(adjoint.sum[k], omega);
    }
}
