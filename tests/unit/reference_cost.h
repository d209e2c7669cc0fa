/* The cost once more, straight from its definition in long double, sharing no code with src/: 4x4
 * transforms, sums over rows, no centring tricks.  What gradients are checked against. */
#ifndef MUKCA_TESTS_REFERENCE_COST_H
#define MUKCA_TESTS_REFERENCE_COST_H

#include <math.h>
#include <string.h>

#include "fit/cost.h"

typedef long double real;

static void reference_multiply(real C[16], const real A[16], const real B[16])
{
    real out[16];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            out[4 * i + j] = 0;
            for (int k = 0; k < 4; k++) out[4 * i + j] += A[4 * i + k] * B[4 * k + j];
        }
    memcpy(C, out, sizeof out);
}

/* Rotation by |w| about w (Rodrigues) and a translation. */
static void reference_screw(real T[16], const real w[3], const real p[3])
{
    const real angle = sqrtl(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    const real a = angle > 0 ? sinl(angle) / angle : 1;
    const real h = angle > 0 ? sinl(angle / 2) / angle : 0.5L, b = 2 * h * h;
    const real K[9] = {0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            real square = 0;
            for (int k = 0; k < 3; k++) square += K[3 * i + k] * K[3 * k + j];
            T[4 * i + j] = (i == j) + a * K[3 * i + j] + b * square;
        }
        T[4 * i + 3] = p[i];
        T[12 + i] = 0;
    }
    T[15] = 1;
}

static void reference_turn(real T[16], int axis, real angle)
{
    real w[3] = {0, 0, 0}, p[3] = {0, 0, 0}, R[16];
    w[axis] = angle;
    reference_screw(R, w, p);
    reference_multiply(T, T, R);
}

/* T = tip in the base. */
static void reference_pose(real T[16], const mukca_chain *chain, const real *theta, const double *q)
{
    static const real zero[3] = {0, 0, 0};
    real step[16], w[3], p[3];
    reference_screw(T, zero, zero);
    for (int k = 0; k < chain->n_elements; k++) {
        const mukca_element *e = &chain->element[k];
        reference_screw(step, zero, theta + 6 * k);
        reference_turn(step, 2, theta[6 * k + 5]);
        reference_turn(step, 1, theta[6 * k + 4]);
        reference_turn(step, 0, theta[6 * k + 3]);
        reference_multiply(T, T, step);
        if (e->joint < 0) continue;
        const real angle = q[e->joint];
        const bool slides = e->type == MUKCA_PRISMATIC;
        for (int i = 0; i < 3; i++) {
            w[i] = slides ? 0 : angle * e->axis[i];
            p[i] = slides ? angle * e->axis[i] : 0;
        }
        reference_screw(step, w, p);
        reference_multiply(T, T, step);
    }
}

/* Squared rotation angle between T and a unit quaternion (w first). */
static real reference_turned(const real T[16], const double *q)
{
    const real w = q[0], x = q[1], y = q[2], z = q[3];
    const real M[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                       2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                       2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    real off[9], s[3], trace = 0, length = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            off[3 * i + j] = 0;
            for (int k = 0; k < 3; k++) off[3 * i + j] += T[4 * i + k] * M[3 * j + k];
        }
    for (int i = 0; i < 3; i++) trace += off[4 * i];
    s[0] = off[7] - off[5], s[1] = off[2] - off[6], s[2] = off[3] - off[1];
    for (int i = 0; i < 3; i++) length += s[i] * s[i];
    const real angle = atan2l(sqrtl(length), trace - 1);
    return angle * angle;
}

/* J, m^2; at most 64 sockets. */
static real reference_cost(const mukca_chain *chain, const mukca_dataset *data, const real *theta,
                           const mukca_parameters *parameters, const mukca_cost_options *options)
{
    real sum[64][3], T[16], nominal[MUKCA_MAX_FREE], cost = 0;
    int count[64], groups = 0;
    double theta_nominal[MUKCA_MAX_FREE];
    mukca_chain_theta(theta_nominal, chain);
    for (int i = 0; i < 6 * chain->n_elements; i++) nominal[i] = theta_nominal[i];
    memset(count, 0, sizeof count);
    for (int s = 0; s < 64; s++)
        for (int a = 0; a < 3; a++) sum[s][a] = 0;
    for (int i = 0; i < data->n_rows; i++) {
        const int s = data->socket[i];
        if (s < 0) continue;
        count[s]++;
        reference_pose(T, chain, theta, data->q + i * data->n_joints);
        for (int a = 0; a < 3; a++) sum[s][a] += T[4 * a + 3];
    }
    for (int g = 0; g <= data->n_placements; g++) {
        real squares = 0;
        int rows = 0;
        for (int i = 0; i < data->n_rows; i++) {
            const int s = data->socket[i];
            const bool pose = s < 0;
            if ((pose ? data->n_placements : data->sockets[s].placement) != g) continue;
            const bool placed = pose && data->position && isfinite(data->position[3 * i]);
            const bool turned = pose && data->quaternion && isfinite(data->quaternion[4 * i]);
            if (pose && !placed && !turned) continue;
            rows++;
            reference_pose(T, chain, theta, data->q + i * data->n_joints);
            for (int a = 0; a < 3; a++) {
                const real about = placed ? (real)data->position[3 * i + a]
                                   : pose ? T[4 * a + 3]
                                          : sum[s][a] / count[s];
                squares += (T[4 * a + 3] - about) * (T[4 * a + 3] - about);
            }
            if (turned) {
                const real per = 0.1L;
                squares += per * per * reference_turned(T, data->quaternion + 4 * i);
            }
        }
        if (rows > 0) cost += squares / rows;
        groups += rows > 0;
    }
    for (int p = 0; p < data->n_distances; p++) {
        const int a = data->distances[p].a, b = data->distances[p].b;
        real square = 0;
        if (count[a] == 0 || count[b] == 0) continue;
        for (int i = 0; i < 3; i++) {
            const real gap = sum[a][i] / count[a] - sum[b][i] / count[b];
            square += gap * gap;
        }
        const real off = sqrtl(square) - data->distances[p].distance;
        cost += off * off;
    }
    const real lambda = options->lambda < 0 ? 0 : options->lambda > 0 ? options->lambda : 1e-4;
    for (int i = 0; i < parameters->n; i++) {
        const real off = theta[parameters->index[i]] - nominal[parameters->index[i]];
        if (parameters->regularised[i]) cost += groups * lambda * off * off;
    }
    return cost;
}

#endif
