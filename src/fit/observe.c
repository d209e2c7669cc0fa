/* Observations to residuals and their Jacobian: one interface for sockets and for measured poses.
 */
#include "fit/observe.h"

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

/* Rows of each socket, and of the group that a row belongs to (n_placements: the poses). */
static int rows_of_group(const mukca_dataset *data, int group)
{
    int n = 0;
    for (int i = 0; i < data->n_rows; i++) {
        const int placement = mukca_dataset_placement(data, i);
        if (placement == group) n++;
        if (placement < 0 && group == data->n_placements)
            n += has_position(data, i) || has_orientation(data, i);
    }
    return n;
}

static int rows_of_socket(const mukca_dataset *data, int socket)
{
    int n = 0;
    for (int i = 0; i < data->n_rows; i++) n += data->socket[i] == socket;
    return n;
}

static bool pair_usable(const mukca_dataset *data, int pair)
{
    return rows_of_socket(data, data->distances[pair].a) > 0 &&
           rows_of_socket(data, data->distances[pair].b) > 0;
}

static void load_rows(mukca_observations *o, const mukca_dataset *data)
{
    const int n = data->n_rows;
    o->n_groups = o->n_measured = 0;
    for (int i = 0; i < n; i++) o->socket[i] = data->socket[i];
    for (int group = 0; group <= data->n_placements; group++) {
        const int rows = rows_of_group(data, group);
        o->n_groups += rows > 0;
        for (int i = 0; i < n && rows > 0; i++) {
            const int placement = mukca_dataset_placement(data, i);
            if ((placement < 0 ? data->n_placements : placement) != group) continue;
            const bool position = placement >= 0 || has_position(data, i);
            const bool orientation = has_orientation(data, i);
            o->share[i] = position ? 1.0 / rows : 0;
            if (o->oriented) o->turn_share[i] = orientation ? 1.0 / rows : 0;
            o->n_measured += 3 * (position + orientation);
            if (o->target)
                for (int a = 0; a < 3; a++)
                    o->target[3 * i + a] = has_position(data, i) ? data->position[3 * i + a] : 0;
            if (orientation)
                mukca_rotation_from_quaternion(o->aim + 9 * i, data->quaternion + 4 * i);
        }
    }
    for (int s = 0; s < o->n_sockets; s++) {
        o->count[s] = rows_of_socket(data, s);
        o->n_measured -= o->count[s] > 0 ? 3 : 0;
    }
    o->n_measured += o->n_pairs;
    for (int p = 0, to = 0; p < data->n_distances; p++) {
        if (!pair_usable(data, p)) continue;
        o->pair[2 * to] = data->distances[p].a;
        o->pair[2 * to + 1] = data->distances[p].b;
        o->pair_distance[to++] = data->distances[p].distance;
    }
}

size_t mukca_observe_setup(mukca_observations *o, void *memory, const mukca_chain *chain,
                           const mukca_dataset *data, const mukca_observe_options *options,
                           int max_free)
{
    mukca_arena arena = {.base = memory};
    const mukca_observe_options none = {0};
    const int n = data->n_rows;
    bool posed = false;
    if (!options) options = &none;
    memset(o, 0, sizeof *o);
    for (int i = 0; i < n; i++) {
        posed |= data->socket[i] < 0;
        o->oriented |= has_orientation(data, i);
    }
    for (int p = 0; p < data->n_distances; p++) o->n_pairs += pair_usable(data, p);
    o->n_rows = n;
    o->n_sockets = data->n_sockets;
    o->n_residuals = (o->oriented ? 6 : 3) * n + o->n_pairs;
    o->max_free = max_free;
    o->metres_per_radian = options->metres_per_radian > 0 ? options->metres_per_radian : 0.1;

    mukca_sweep_carve(&o->sweep, &arena, chain, n, options->displacements != NULL);
    const int padded = o->sweep.padded;
    o->socket = MUKCA_CARVE(&arena, int, n);
    o->share = MUKCA_CARVE(&arena, double, n);
    o->count = MUKCA_CARVE(&arena, double, o->n_sockets);
    o->mean = MUKCA_CARVE(&arena, double, 3 * o->n_sockets);
    o->mean_rows = MUKCA_CARVE(&arena, double, 3 * o->n_sockets * max_free);
    o->pair = MUKCA_CARVE(&arena, int, 2 * o->n_pairs);
    o->pair_distance = MUKCA_CARVE(&arena, double, o->n_pairs);
    o->pair_residual = MUKCA_CARVE(&arena, double, o->n_pairs);
    o->pair_direction = MUKCA_CARVE(&arena, double, 3 * o->n_pairs);
    o->residual = MUKCA_CARVE(&arena, double, 3 * padded);
    o->adjoint = MUKCA_CARVE(&arena, double, 3 * padded);
    if (posed) o->target = MUKCA_CARVE(&arena, double, 3 * n);
    if (o->oriented) {
        o->turn_share = MUKCA_CARVE(&arena, double, n);
        o->aim = MUKCA_CARVE(&arena, double, 9 * n);
        o->turn_residual = MUKCA_CARVE(&arena, double, 3 * padded);
    }
    double *pull = options->pull_theta ? MUKCA_CARVE(&arena, double, 3 * o->n_sockets) : NULL;
    if (!memory) return arena.used;

    memset(memory, 0, arena.used);
    load_rows(o, data);
    mukca_sweep_load(&o->sweep, chain, data->q, options->displacements);
    if (options->pull_theta) {
        mukca_observe_predict(o, options->pull_theta);
        memcpy(pull, o->mean, 3 * (size_t)o->n_sockets * sizeof *pull);
        o->pull = pull;
    }
    return arena.used;
}

static void predict_pairs(mukca_observations *o)
{
    for (int p = 0; p < o->n_pairs; p++) {
        const double *a = o->mean + 3 * o->pair[2 * p], *b = o->mean + 3 * o->pair[2 * p + 1];
        double *u = o->pair_direction + 3 * p;
        for (int i = 0; i < 3; i++) u[i] = a[i] - b[i];
        const double length = sqrt(mukca_dot3(u, u));
        for (int i = 0; i < 3; i++) u[i] = length > 0 ? u[i] / length : 0;
        o->pair_residual[p] = length - o->pair_distance[p];
    }
}

static void predict_orientations(mukca_observations *o)
{
    const int padded = o->sweep.padded;
    mukca_sweep_orientations(&o->sweep);
    for (int i = 0; i < o->n_rows; i++) {
        double R[9], off[9], w[3] = {0, 0, 0};
        if (o->turn_share[i] > 0) {
            for (int r = 0; r < 3; r++)
                for (int c = 0; c < 3; c++) {
                    off[3 * r + c] = 0;
                    for (int m = 0; m < 3; m++) /* predicted times measured transposed */
                        off[3 * r + c] +=
                            o->sweep.Q[(3 * r + m) * padded + i] * o->aim[9 * i + 3 * c + m];
                }
            memcpy(R, off, sizeof R);
            mukca_rotation_log(w, R);
        }
        for (int a = 0; a < 3; a++) o->turn_residual[a * padded + i] = o->metres_per_radian * w[a];
    }
}

void mukca_observe_predict(mukca_observations *o, const double *theta)
{
    const int padded = o->sweep.padded;
    const double *x = o->sweep.x;
    mukca_sweep_origins(&o->sweep, theta);
    mukca_sweep_forward(&o->sweep);
    memset(o->mean, 0, 3 * (size_t)o->n_sockets * sizeof *o->mean);
    for (int i = 0; i < o->n_rows; i++)
        if (o->socket[i] >= 0)
            for (int a = 0; a < 3; a++) o->mean[3 * o->socket[i] + a] += x[a * padded + i];
    for (int s = 0; s < o->n_sockets; s++)
        for (int a = 0; a < 3 && o->count[s] > 0; a++) o->mean[3 * s + a] /= o->count[s];
    const double *centre = o->pull ? o->pull : o->mean;
    for (int i = 0; i < o->n_rows; i++) {
        const double *about = o->socket[i] >= 0 ? centre + 3 * o->socket[i] : o->target + 3 * i;
        for (int a = 0; a < 3; a++)
            o->residual[a * padded + i] = o->share[i] > 0 ? x[a * padded + i] - about[a] : 0;
    }
    predict_pairs(o);
    if (o->oriented) predict_orientations(o);
}

double mukca_observe_squares(double *pairs, const mukca_observations *o)
{
    const int padded = o->sweep.padded;
    double sum = 0;
    for (int i = 0; i < o->n_rows; i++) {
        double row = 0, turn = 0;
        for (int a = 0; a < 3; a++) {
            row += o->residual[a * padded + i] * o->residual[a * padded + i];
            if (o->oriented)
                turn += o->turn_residual[a * padded + i] * o->turn_residual[a * padded + i];
        }
        sum += o->share[i] * row;
        if (o->oriented) sum += o->turn_share[i] * turn;
    }
    if (pairs) {
        *pairs = 0;
        for (int p = 0; p < o->n_pairs; p++) *pairs += o->pair_residual[p] * o->pair_residual[p];
    }
    return sum;
}

/* What a pair's residual adds to the adjoint of the rows of socket s. */
static void pair_adjoint(double add[3], const mukca_observations *o, int s, double weight)
{
    add[0] = add[1] = add[2] = 0;
    for (int p = 0; p < o->n_pairs; p++) {
        const int sign = (o->pair[2 * p] == s) - (o->pair[2 * p + 1] == s);
        const double f = 2 * weight * sign * o->pair_residual[p] / o->count[s];
        for (int a = 0; a < 3; a++) add[a] += f * o->pair_direction[3 * p + a];
    }
}

/* gradient += what the adjoint of the tip's orientation says by the rotations. */
static void add_orientations(double *gradient, mukca_observations *o, const double *theta,
                             const mukca_parameters *parameters, mukca_gradient kind)
{
    const int padded = o->sweep.padded;
    mukca_adjoint adjoint;
    for (int i = 0; i < o->n_rows; i++)
        for (int a = 0; a < 3; a++)
            o->adjoint[a * padded + i] =
                2 * o->turn_share[i] * o->metres_per_radian * o->turn_residual[a * padded + i];
    mukca_sweep_backward(&adjoint, o->adjoint, &o->sweep);
    for (int i = 0; i < parameters->n; i++) {
        const int k = parameters->index[i] / MUKCA_PARAMETERS;
        const int parameter = parameters->index[i] % MUKCA_PARAMETERS;
        double dR[3][9], R[9], Rt[9], spin[9];
        if (parameter < 3) continue;
        mukca_sweep_element_derivative(dR, theta + 6 * k + 3, kind);
        mukca_rotation_from_rpy(R, theta + 6 * k + 3);
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++) Rt[3 * r + c] = R[3 * c + r];
        mukca_mat3_mul(spin, dR[parameter - 3], Rt);
        gradient[i] += 0.5 * (adjoint.sum[k][0] * (spin[7] - spin[5]) +
                              adjoint.sum[k][1] * (spin[2] - spin[6]) +
                              adjoint.sum[k][2] * (spin[3] - spin[1]));
    }
}

void mukca_observe_gradient(double *gradient, mukca_observations *o, const double *theta,
                            const mukca_parameters *parameters, mukca_gradient kind,
                            double pair_weight)
{
    const int padded = o->sweep.padded;
    mukca_adjoint adjoint;
    memset(o->adjoint, 0, 3 * (size_t)padded * sizeof *o->adjoint);
    for (int s = 0; s < o->n_sockets; s++) /* parked in the scratch of the Jacobian */
        pair_adjoint(o->mean_rows + 3 * s, o, s, pair_weight);
    for (int i = 0; i < o->n_rows; i++)
        for (int a = 0; a < 3; a++)
            o->adjoint[a * padded + i] =
                2 * o->share[i] * o->residual[a * padded + i] +
                (o->socket[i] >= 0 ? o->mean_rows[3 * o->socket[i] + a] : 0);
    mukca_sweep_backward(&adjoint, o->adjoint, &o->sweep);
    for (int i = 0; i < parameters->n;) {
        const int k = parameters->index[i] / MUKCA_PARAMETERS;
        double dR[3][9];
        mukca_sweep_element_derivative(dR, theta + 6 * k + 3, kind);
        for (; i < parameters->n && parameters->index[i] / MUKCA_PARAMETERS == k; i++) {
            const int parameter = parameters->index[i] % MUKCA_PARAMETERS;
            gradient[i] = parameter < 3 ? adjoint.sum[k][parameter] : 0;
            for (int c = 0; c < 9 && parameter >= 3; c++)
                gradient[i] += dR[parameter - 3][c] * adjoint.outer[k][c];
        }
    }
    if (o->oriented) add_orientations(gradient, o, theta, parameters, kind);
}

/* J rows of one orientation: derivative of the rotation vector w, not of the rotation itself. */
static void turn_rows_of(double *J, int n, const double w[3], double metres_per_radian)
{
    const double angle = sqrt(mukca_dot3(w, w));
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
        for (int a = 0; a < 3; a++) J[a * n + i] = metres_per_radian * u[a];
    }
}

static void jacobian_of(double *J, mukca_observations *o, const double *theta,
                        const mukca_parameters *parameters, mukca_gradient kind)
{
    const int n = parameters->n, padded = o->sweep.padded;
    double *JO = o->oriented ? J + 3 * o->n_rows * n : NULL;
    mukca_sweep_jacobian(J, JO, &o->sweep, theta, parameters, kind);
    memset(o->mean_rows, 0, 3 * (size_t)(o->n_sockets * n) * sizeof *o->mean_rows);
    for (int i = 0; i < o->n_rows; i++) {
        if (o->socket[i] < 0) continue;
        double *mean = o->mean_rows + 3 * o->socket[i] * n;
        for (int c = 0; c < 3 * n; c++) mean[c] += J[3 * i * n + c];
    }
    for (int s = 0; s < o->n_sockets; s++)
        for (int c = 0; c < 3 * n && o->count[s] > 0; c++)
            o->mean_rows[3 * s * n + c] /= o->count[s];
    for (int i = 0; i < o->n_rows; i++) {
        double *rows = J + 3 * i * n;
        if (o->socket[i] >= 0 && !o->pull) {
            const double *mean = o->mean_rows + 3 * o->socket[i] * n;
            for (int c = 0; c < 3 * n; c++) rows[c] -= mean[c];
        }
        if (!(o->share[i] > 0)) memset(rows, 0, 3 * (size_t)n * sizeof *rows);
        if (!JO) continue;
        const double w[3] = {o->turn_residual[i] / o->metres_per_radian,
                             o->turn_residual[padded + i] / o->metres_per_radian,
                             o->turn_residual[2 * padded + i] / o->metres_per_radian};
        if (o->turn_share[i] > 0)
            turn_rows_of(JO + 3 * i * n, n, w, o->metres_per_radian);
        else
            memset(JO + 3 * i * n, 0, 3 * (size_t)n * sizeof *JO);
    }
    double *row = J + (o->oriented ? 6 : 3) * o->n_rows * n;
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
    const int padded = o->sweep.padded, n = o->n_rows;
    mukca_observe_predict(o, theta);
    for (int i = 0; i < n; i++)
        for (int a = 0; a < 3; a++) {
            r[3 * i + a] = o->residual[a * padded + i];
            if (o->oriented) r[3 * n + 3 * i + a] = o->turn_residual[a * padded + i];
        }
    memcpy(r + (o->oriented ? 6 : 3) * n, o->pair_residual,
           (size_t)o->n_pairs * sizeof *o->pair_residual);
    if (J) jacobian_of(J, o, theta, parameters, kind);
}

void mukca_observe_weights(double *weight, const mukca_observations *o, double pair_weight)
{
    for (int i = 0; i < o->n_rows; i++)
        for (int a = 0; a < 3; a++) {
            weight[3 * i + a] = sqrt(o->share[i]);
            if (o->oriented) weight[3 * (o->n_rows + i) + a] = sqrt(o->turn_share[i]);
        }
    for (int p = 0; p < o->n_pairs; p++)
        weight[(o->oriented ? 6 : 3) * o->n_rows + p] = sqrt(pair_weight);
}
