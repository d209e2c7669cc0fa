/* Forward kinematics: position, pose, frames, Jacobians; one configuration or many. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "base/clones.h"
#include "mukca/chain.h"

/* v := R(axis, angle) v given the sine and cosine. */
static inline void turn_vector(double v[3], const double axis[3], int axis_z, double s, double c)
{
    if (axis_z) {
        const double sz = axis_z * s, x = v[0];
        v[0] = c * x - sz * v[1];
        v[1] = sz * x + c * v[1];
        return;
    }
    double cross[3];
    mukca_cross(cross, axis, v);
    const double along = (1 - c) * mukca_dot3(axis, v);
    for (int i = 0; i < 3; i++) v[i] = c * v[i] + s * cross[i] + along * axis[i];
}

void mukca_fk_position(double position[3], const mukca_geometry *geometry, const double *q,
                       const mukca_displacement *displacement)
{
    double v[3] = {0, 0, 0};
    if (displacement) memcpy(v, displacement->tip, sizeof v);
    for (int k = geometry->n_elements - 1; k >= 0; k--) {
        const int j = geometry->joint[k];
        if (j >= 0) {
            const double angle = displacement ? q[j] + displacement->q[j] : q[j];
            if (geometry->type[k] == MUKCA_PRISMATIC) {
                for (int i = 0; i < 3; i++) v[i] += angle * geometry->axis[k][i];
            } else {
                turn_vector(v, geometry->axis[k], geometry->axis_z[k], sin(angle), cos(angle));
            }
            if (displacement && displacement->any_rotation) {
                double R[9], u[3] = {v[0], v[1], v[2]};
                mukca_rotation_exp(R, displacement->rotation[j]);
                mukca_mat3_vec(v, R, u);
            }
        }
        double u[3];
        mukca_mat3_vec(u, geometry->origin[k].R, v);
        for (int i = 0; i < 3; i++) v[i] = u[i] + geometry->origin[k].p[i];
    }
    if (displacement && displacement->any_rotation) {
        double R[9];
        mukca_rotation_exp(R, displacement->base);
        mukca_mat3_vec(position, R, v);
    } else {
        memcpy(position, v, sizeof v);
    }
}

/* frame := frame * (joint turned by q, with its displacement). */
static void turn_frame(mukca_frame *frame, const mukca_geometry *geometry, int k, const double *q,
                       const mukca_displacement *displacement)
{
    const int j = geometry->joint[k];
    if (j < 0) return;
    double R[9], turned[9];
    const double angle = displacement ? q[j] + displacement->q[j] : q[j];
    if (displacement && displacement->any_rotation) {
        mukca_rotation_exp(R, displacement->rotation[j]);
        mukca_mat3_mul(turned, frame->R, R);
        memcpy(frame->R, turned, sizeof turned);
    }
    if (geometry->type[k] == MUKCA_PRISMATIC) {
        double step[3];
        mukca_mat3_vec(step, frame->R, geometry->axis[k]);
        for (int i = 0; i < 3; i++) frame->p[i] += angle * step[i];
        return;
    }
    mukca_rotation_about(R, geometry->axis[k], angle);
    mukca_mat3_mul(turned, frame->R, R);
    memcpy(frame->R, turned, sizeof turned);
}

void mukca_fk_frames(mukca_frame *before, mukca_frame *tip, const mukca_geometry *geometry,
                     const double *q, const mukca_displacement *displacement)
{
    mukca_frame frame = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    if (displacement && displacement->any_rotation) mukca_rotation_exp(frame.R, displacement->base);
    for (int k = 0; k < geometry->n_elements; k++) {
        mukca_frame_multiply(&frame, &frame, &geometry->origin[k]);
        if (before) before[k] = frame;
        turn_frame(&frame, geometry, k, q, displacement);
    }
    if (displacement) {
        double shift[3];
        mukca_mat3_vec(shift, frame.R, displacement->tip);
        for (int i = 0; i < 3; i++) frame.p[i] += shift[i];
    }
    if (tip) *tip = frame;
}

void mukca_fk_pose(mukca_frame *T_base_tip, const mukca_geometry *geometry, const double *q,
                   const mukca_displacement *displacement)
{
    mukca_fk_frames(NULL, T_base_tip, geometry, q, displacement);
}

void mukca_fk_jacobian(double *J, mukca_frame *T_base_tip, const mukca_geometry *geometry,
                       const double *q, const mukca_displacement *displacement)
{
    mukca_frame before[MUKCA_MAX_ELEMENTS], tip;
    const int n = geometry->n_joints;
    mukca_fk_frames(before, &tip, geometry, q, displacement);
    for (int k = 0; k < geometry->n_elements; k++) {
        const int j = geometry->joint[k];
        if (j < 0) continue;
        double local[3], axis[3], lever[3], linear[3] = {0, 0, 0}, angular[3] = {0, 0, 0};
        memcpy(local, geometry->axis[k], sizeof local);
        if (displacement && displacement->any_rotation) {
            double R[9];
            mukca_rotation_exp(R, displacement->rotation[j]);
            mukca_mat3_vec(local, R, geometry->axis[k]);
        }
        mukca_mat3_vec(axis, before[k].R, local);
        if (geometry->type[k] == MUKCA_PRISMATIC) {
            memcpy(linear, axis, sizeof axis);
        } else {
            for (int i = 0; i < 3; i++) lever[i] = tip.p[i] - before[k].p[i];
            mukca_cross(linear, axis, lever);
            memcpy(angular, axis, sizeof axis);
        }
        for (int i = 0; i < 3; i++) J[i * n + j] = linear[i], J[(3 + i) * n + j] = angular[i];
    }
    if (T_base_tip) *T_base_tip = tip;
}

void mukca_fk_parameter_jacobian(double *J, double position[3], const mukca_geometry *geometry,
                                 const double *theta, const double *q)
{
    const int n = geometry->n_elements, width = MUKCA_PARAMETERS * n;
    double parent[MUKCA_MAX_ELEMENTS][9]; /* orientation of each element's parent frame */
    double v[3] = {0, 0, 0}, s[MUKCA_MAX_JOINTS], c[MUKCA_MAX_JOINTS];
    double R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (int j = 0; j < geometry->n_joints; j++) s[j] = sin(q[j]), c[j] = cos(q[j]);
    for (int k = 0; k < n; k++) {
        const int j = geometry->joint[k];
        double turned[9];
        memcpy(parent[k], R, sizeof R);
        mukca_mat3_mul(turned, R, geometry->origin[k].R);
        memcpy(R, turned, sizeof R);
        if (j < 0 || geometry->type[k] == MUKCA_PRISMATIC) continue;
        for (int row = 0; row < 3; row++) /* R := R R(axis, q), as rows turned backwards */
            turn_vector(R + 3 * row, geometry->axis[k], geometry->axis_z[k], -s[j], c[j]);
    }
    for (int k = n - 1; k >= 0; k--) {
        const int j = geometry->joint[k];
        const double *O = geometry->origin[k].R, yaw = theta[6 * k + 5];
        /* roll, pitch and yaw turn about these axes of the parent's frame */
        const double axes[3][3] = {{O[0], O[3], O[6]}, {-sin(yaw), cos(yaw), 0}, {0, 0, 1}};
        double u[3], turned[3], column[3];
        if (j >= 0 && geometry->type[k] == MUKCA_PRISMATIC)
            for (int i = 0; i < 3; i++) v[i] += q[j] * geometry->axis[k][i];
        else if (j >= 0)
            turn_vector(v, geometry->axis[k], geometry->axis_z[k], s[j], c[j]);
        mukca_mat3_vec(u, O, v);
        for (int i = 0; i < 3; i++) {
            mukca_cross(turned, axes[i], u);
            mukca_mat3_vec(column, parent[k], turned);
            for (int row = 0; row < 3; row++) {
                J[row * width + 6 * k + i] = parent[k][3 * row + i];
                J[row * width + 6 * k + 3 + i] = column[row];
            }
        }
        for (int i = 0; i < 3; i++) v[i] = u[i] + geometry->origin[k].p[i];
    }
    if (position) memcpy(position, v, sizeof v);
}

enum { LANES = 8 };

/* Sine and cosine of eight angles; absolute error under 3e-16 for |x| < 1e5, NaN beyond.
 * Cody-Waite reduction by pi/2 and the polynomials of fdlibm's kernels; no branch, so that the
 * compiler vectorises it. */
static inline void sincos_lanes(double *s, double *c, const double *x)
{
    for (int l = 0; l < LANES; l++) {
        union {
            double d;
            uint64_t u;
        } shifted;
        shifted.d = x[l] * 0.63661977236758134308 + 0x1.8p52;
        const double n = shifted.d - 0x1.8p52;
        double r = x[l] - n * 1.57079632673412561417e+00;
        r -= n * 6.07710050630396597660e-11;
        r -= n * 2.02226624879595063154e-21;
        const double z = r * r;
        const double sine = r + r * z *
                                    (-1.66666666666666324348e-01 +
                                     z * (8.33333333332248946124e-03 +
                                          z * (-1.98412698298579493134e-04 +
                                               z * (2.75573137070700676789e-06 +
                                                    z * (-2.50507602534068634195e-08 +
                                                         z * 1.58969099521155010221e-10)))));
        const double cosine = 1 - 0.5 * z +
                              z * z *
                                  (4.16666666666666019037e-02 +
                                   z * (-1.38888888888741095749e-03 +
                                        z * (2.48015872894767294178e-05 +
                                             z * (-2.75573143513906633035e-07 +
                                                  z * (2.08757232129817482790e-09 -
                                                       z * 1.13596475577881948265e-11)))));
        const uint64_t quadrant = shifted.u & 3u;
        const double odd = (double)(quadrant & 1u);
        const double sign_s = 1.0 - (double)(quadrant & 2u);
        const double sign_c = 1.0 - (double)((quadrant + 1u) & 2u);
        const double valid = n - n; /* 0, or NaN for an infinite angle */
        s[l] = sign_s * (odd * cosine + (1 - odd) * sine) + valid;
        c[l] = sign_c * (odd * sine + (1 - odd) * cosine) + valid;
    }
}

MUKCA_CLONES static void positions_block(double (*restrict out)[LANES],
                                         const mukca_geometry *restrict geometry,
                                         const double (*restrict q)[LANES])
{
    double x[LANES] = {0}, y[LANES] = {0}, z[LANES] = {0};
    for (int k = geometry->n_elements - 1; k >= 0; k--) {
        const int j = geometry->joint[k];
        const double *a = geometry->axis[k], *R = geometry->origin[k].R, *p = geometry->origin[k].p;
        if (j >= 0 && geometry->type[k] == MUKCA_PRISMATIC) {
            for (int l = 0; l < LANES; l++) {
                x[l] += q[j][l] * a[0];
                y[l] += q[j][l] * a[1];
                z[l] += q[j][l] * a[2];
            }
        } else if (j >= 0) {
            double s[LANES], c[LANES];
            sincos_lanes(s, c, q[j]);
            if (geometry->axis_z[k]) {
                const double sign = geometry->axis_z[k];
                for (int l = 0; l < LANES; l++) {
                    const double xl = x[l], sz = sign * s[l];
                    x[l] = c[l] * xl - sz * y[l];
                    y[l] = sz * xl + c[l] * y[l];
                }
            } else {
                for (int l = 0; l < LANES; l++) {
                    const double xl = x[l], yl = y[l], zl = z[l];
                    const double along = (1 - c[l]) * (a[0] * xl + a[1] * yl + a[2] * zl);
                    x[l] = c[l] * xl + s[l] * (a[1] * zl - a[2] * yl) + along * a[0];
                    y[l] = c[l] * yl + s[l] * (a[2] * xl - a[0] * zl) + along * a[1];
                    z[l] = c[l] * zl + s[l] * (a[0] * yl - a[1] * xl) + along * a[2];
                }
            }
        }
        for (int l = 0; l < LANES; l++) {
            const double xl = x[l], yl = y[l], zl = z[l];
            x[l] = R[0] * xl + R[1] * yl + R[2] * zl + p[0];
            y[l] = R[3] * xl + R[4] * yl + R[5] * zl + p[1];
            z[l] = R[6] * xl + R[7] * yl + R[8] * zl + p[2];
        }
    }
    memcpy(out[0], x, sizeof x);
    memcpy(out[1], y, sizeof y);
    memcpy(out[2], z, sizeof z);
}

void mukca_fk_positions(double *positions, const mukca_geometry *geometry, const double *q,
                        int rows)
{
    const int n = geometry->n_joints;
    double block[MUKCA_MAX_JOINTS][LANES], out[3][LANES];
    for (int start = 0; start < rows; start += LANES) {
        const int m = rows - start < LANES ? rows - start : LANES;
        int wide = 0; /* an angle that the fast reduction does not cover */
        for (int j = 0; j < n; j++)
            for (int l = 0; l < LANES; l++) {
                const double angle = q[(start + (l < m ? l : 0)) * n + j];
                block[j][l] = angle;
                wide |= !(fabs(angle) < 1e5);
            }
        if (wide) {
            for (int l = 0; l < m; l++)
                mukca_fk_position(positions + 3 * (start + l), geometry, q + (start + l) * n, NULL);
            continue;
        }
        positions_block(out, geometry, (const double(*)[LANES])block);
        for (int l = 0; l < m; l++)
            for (int i = 0; i < 3; i++) positions[3 * (start + l) + i] = out[i][l];
    }
}
