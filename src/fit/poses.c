/* Measured poses: residuals and gradient of orientations; the Jacobian of all residuals. */
#include "fit/poses.h"

#include <math.h>
#include <string.h>

#include "fit/rows.h"

/* ---- orientations and Jacobian of a sweep ---- */

/* Q := Q R Rz(q) for every sample: the rows of Q are vectors x[3][padded], multiplied by R from the
 * right. */
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

/* Compute Q, the tip's orientation in the base, for the origins in use. */
MUKCA_CLONES static void find_orientations(mukca_sweep *sweep)
{
    double back[9]; /* from aligned to true coordinates of the last frame */
    transpose(back, sweep->align[sweep->n_elements]);
    frames_start(sweep->Q, sweep->padded);
    for (int k = 0; k < sweep->n_elements; k++) frames_times(sweep->Q, sweep->R[k], sweep, k);
    frames_times(sweep->Q, back, sweep, -1);
}

/* Angular velocity of a rotation R with derivative dR: the antisymmetric part of dR R'. */
static void find_spin(double omega[3], const double dR[9], const double R[9])
{
    double Rt[9], spin[9];
    transpose(Rt, R);
    mukca_mat3_mul(spin, dR, Rt);
    omega[0] = 0.5 * (spin[7] - spin[5]);
    omega[1] = 0.5 * (spin[2] - spin[6]);
    omega[2] = 0.5 * (spin[3] - spin[1]);
}

/* Column `column` of J: sample i gets Q_i v_i.  v[3] is the same for all samples; with `each`,
 * v[3][padded] has one per sample. */
MUKCA_INLINE void column_rows(double *J, int ld, int column, const double *v, bool each,
                              const mukca_sweep *sweep)
{
    const int padded = sweep->padded, rows = sweep->rows, stride = each ? padded : 1;
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
    double *v = sweep->h;
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
            find_spin(omega, M, sweep->R[k]);
            column_rows(JO, n, column, omega, false, sweep);
        }
        frames_times(sweep->Q, sweep->R[k], sweep, k);
    }
}

/* ---- residuals and gradient ---- */

static bool has_position(const mukca_dataset *data, int row)
{
    return data->socket[row] < 0 && data->position && isfinite(data->position[3 * row]);
}

static bool has_orientation(const mukca_dataset *data, int row)
{
    return data->socket[row] < 0 && data->quaternion && isfinite(data->quaternion[4 * row]);
}

bool mukca_poses_add(mukca_observations *o, mukca_pool *pool, const mukca_dataset *data, int n)
{
    int rows = 0, poses = 0, oriented = 0;
    o->mean_rows = MUKCA_TAKE(pool, double, 3 * o->n_sockets * n);
    for (int i = 0; i < o->n_rows; i++) {
        rows += data->socket[i] < 0;
        poses += has_position(data, i) || has_orientation(data, i);
        oriented += has_orientation(data, i);
    }
    if (rows == 0) return !pool->failed;
    o->target = data->position;
    if (oriented) {
        o->aim = data->quaternion;
        o->turn_weight = MUKCA_TAKE(pool, double, o->n_rows);
        o->turn_residual = MUKCA_TAKE(pool, double, 3 * (o->n_rows + MUKCA_SWEEP_PADDING));
        o->n_residuals += 3 * o->n_rows;
    }
    o->n_groups += poses > 0;
    o->n_measured += 3 * oriented;
    for (int i = 0; i < o->n_rows && !pool->failed; i++) {
        if (has_position(data, i)) o->row_weight[i] = 1.0 / poses, o->n_measured += 3;
        if (has_orientation(data, i)) o->turn_weight[i] = 1.0 / poses;
    }
    return !pool->failed;
}

/* For the open window. */
static void predict_window(mukca_observations *o)
{
    const mukca_sweep *s = &o->sweep;
    double *residual = mukca_observe_window(o->turn_residual, s);
    find_orientations(&o->sweep);
    for (int i = 0; i < s->rows; i++) {
        double R[9], aim[9], w[3] = {0, 0, 0};
        for (int c = 0; c < 9; c++) R[c] = s->Q[c * s->padded + i];
        mukca_rotation_from_quaternion(aim, o->aim + 4L * (s->from + i));
        if (o->turn_weight[s->from + i] > 0) mukca_rotation_difference(w, R, aim);
        for (int a = 0; a < 3; a++) residual[a * s->padded + i] = MUKCA_METRES_PER_RADIAN * w[a];
    }
}

void mukca_orientations_predict(mukca_observations *o)
{
    for (int v = 0; o->turn_weight && mukca_sweep_open(&o->sweep, v); v++) predict_window(o);
}

double mukca_orientations_squares(mukca_observations *o, bool weighted)
{
    if (!o->turn_weight) return 0;
    return mukca_observe_sum(o, o->turn_residual, weighted ? o->turn_weight : NULL);
}

void mukca_orientations_gradient(double *gradient, mukca_observations *o)
{
    const mukca_parameters *parameters = o->parameters;
    mukca_adjoint adjoint = {0};
    if (!o->turn_weight) return;
    for (int v = 0; mukca_sweep_open(&o->sweep, v); v++)
        mukca_observe_adjoint(&adjoint, o, o->turn_residual, o->turn_weight,
                              MUKCA_METRES_PER_RADIAN, NULL);
    for (int i = 0; i < parameters->n;) {
        const int k = parameters->index[i] / MUKCA_PARAMETERS;
        double dR[3][9], R[9], omega[3];
        mukca_sweep_element_derivative(dR, o->theta + 6 * k + 3, o->kind);
        mukca_rotation_from_rpy(R, o->theta + 6 * k + 3);
        for (; i < parameters->n && parameters->index[i] / MUKCA_PARAMETERS == k; i++) {
            const int parameter = parameters->index[i] % MUKCA_PARAMETERS;
            if (parameter < 3) continue;
            find_spin(omega, dR[parameter - 3], R);
            gradient[i] += mukca_dot3(adjoint.sum[k], omega);
        }
    }
}

/* ---- the Jacobian of all residuals ---- */

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
    if (!(o->row_weight[row] > 0)) memset(J, 0, 3 * (size_t)n * sizeof *J);
    if (!JO) return;
    const mukca_sweep *s = &o->sweep;
    const double *turned = mukca_observe_window(o->turn_residual, s) + row - s->from;
    double w[3];
    for (int a = 0; a < 3; a++) w[a] = turned[a * s->padded] / MUKCA_METRES_PER_RADIAN;
    if (o->turn_weight[row] > 0)
        turn_rows_of(JO, n, w);
    else
        memset(JO, 0, 3 * (size_t)n * sizeof *JO);
}

static void jacobian_of(double *J, mukca_observations *o)
{
    const long n = o->parameters->n;
    mukca_sweep *sweep = &o->sweep;
    double *JO = o->turn_weight ? J + 3 * o->n_rows * n : NULL;
    for (int v = 0; mukca_sweep_open(sweep, v); v++) {
        if (sweep->n_windows > 1) mukca_sweep_forward(sweep); /* else still valid */
        const long at = 3 * sweep->from * n;
        mukca_sweep_jacobian(J + at, JO ? JO + at : NULL, sweep, o->theta, o->parameters, o->kind);
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
    for (int v = 0; mukca_sweep_open(sweep, v); v++)
        for (int i = sweep->from; i < sweep->from + sweep->rows; i++)
            finish_rows(J + 3 * i * n, JO ? JO + 3 * i * n : NULL, o, (int)n, i);
    double *row = J + (o->turn_weight ? 6 : 3) * o->n_rows * n;
    for (int p = 0; p < o->n_pairs; p++, row += n) {
        const double *a = o->mean_rows + 3 * o->pair[p].a * n,
                     *b = o->mean_rows + 3 * o->pair[p].b * n;
        const double *u = o->pair[p].direction;
        for (int c = 0; c < n; c++)
            row[c] = u[0] * (a[c] - b[c]) + u[1] * (a[n + c] - b[n + c]) +
                     u[2] * (a[2 * n + c] - b[2 * n + c]);
    }
}

void mukca_observe_residuals(double *r, double *J, mukca_observations *o, const double *theta)
{
    const int n = o->n_rows;
    mukca_sweep *s = &o->sweep;
    mukca_observe_predict(o, theta);
    mukca_orientations_predict(o);
    for (int v = 0; mukca_sweep_open(s, v); v++) {
        const double *residual = mukca_observe_window(o->residual, s);
        for (int i = 0; i < s->rows; i++)
            for (int a = 0; a < 3; a++) r[3 * (s->from + i) + a] = residual[a * s->padded + i];
        residual = o->turn_weight ? mukca_observe_window(o->turn_residual, s) : NULL;
        for (int i = 0; i < s->rows && residual; i++)
            for (int a = 0; a < 3; a++) r[3 * (n + s->from + i) + a] = residual[a * s->padded + i];
    }
    r += (o->turn_weight ? 6 : 3) * n;
    for (int p = 0; p < o->n_pairs; p++) r[p] = o->pair[p].residual;
    if (J) jacobian_of(J, o);
}
