/* Forward kinematics of one configuration: position, pose, frames. */
#include <math.h>
#include <string.h>

#include "model/turn.h"

static const mukca_displacement undisplaced;

void mukca_fk_position(double position[3], const mukca_geometry *geometry, const double *q,
                       const mukca_displacement *displacement)
{
    const mukca_displacement *d = displacement ? displacement : &undisplaced;
    double v[3], u[3], R[9];
    memcpy(v, d->tip, sizeof v);
    for (int k = geometry->n_elements - 1; k >= 0; k--) {
        const int j = geometry->joint[k];
        const double angle = j >= 0 ? q[j] + d->q[j] : 0;
        if (geometry->type[k] == MUKCA_PRISMATIC)
            for (int i = 0; i < 3; i++) v[i] += angle * geometry->axis[k][i];
        else if (j >= 0)
            turn_vector(v, geometry, k, sin(angle), cos(angle));
        if (j >= 0 && d->any_rotation) {
            mukca_rotation_exp(R, d->rotation[j]);
            mukca_mat3_vec(u, R, v);
            memcpy(v, u, sizeof v);
        }
        mukca_mat3_vec(u, geometry->origin[k].R, v);
        for (int i = 0; i < 3; i++) v[i] = u[i] + geometry->origin[k].p[i];
    }
    memcpy(position, v, sizeof v);
    if (!d->any_rotation) return;
    mukca_rotation_exp(R, d->base);
    mukca_mat3_vec(position, R, v);
}

/* frame := frame * (joint of element k at q, displaced). */
static void turn_frame(mukca_frame *frame, const mukca_geometry *geometry, int k, const double *q,
                       const mukca_displacement *d)
{
    const int j = geometry->joint[k];
    if (j < 0) return;
    const double angle = q[j] + d->q[j];
    if (d->any_rotation) {
        double turn[9], R[9];
        mukca_rotation_exp(turn, d->rotation[j]);
        mukca_mat3_mul(R, frame->R, turn);
        memcpy(frame->R, R, sizeof R);
    }
    if (geometry->type[k] == MUKCA_PRISMATIC) {
        double step[3];
        mukca_mat3_vec(step, frame->R, geometry->axis[k]);
        for (int i = 0; i < 3; i++) frame->p[i] += angle * step[i];
        return;
    }
    turn_rows(frame->R, geometry, k, sin(angle), cos(angle));
}

void mukca_fk_frames(mukca_frame *before, mukca_frame *tip, const mukca_geometry *geometry,
                     const double *q, const mukca_displacement *displacement)
{
    const mukca_displacement *d = displacement ? displacement : &undisplaced;
    mukca_frame frame = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    double shift[3];
    if (d->any_rotation) mukca_rotation_exp(frame.R, d->base);
    for (int k = 0; k < geometry->n_elements; k++) {
        mukca_frame_multiply(&frame, &frame, &geometry->origin[k]);
        if (before) before[k] = frame;
        turn_frame(&frame, geometry, k, q, d);
    }
    if (!tip) return;
    *tip = frame;
    mukca_mat3_vec(shift, frame.R, d->tip);
    for (int i = 0; i < 3; i++) tip->p[i] += shift[i];
}

void mukca_fk_pose(mukca_frame *T_base_tip, const mukca_geometry *geometry, const double *q,
                   const mukca_displacement *displacement)
{
    mukca_fk_frames(NULL, T_base_tip, geometry, q, displacement);
}
