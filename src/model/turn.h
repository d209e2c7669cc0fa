/* Rotation of vectors by joints (Rodrigues' formula). */
#ifndef MUKCA_MODEL_TURN_H
#define MUKCA_MODEL_TURN_H

#include "base/clones.h"
#include "mukca/chain.h"

/* v := R(axis of element k, angle) v, given the angle's sine and cosine. */
MUKCA_INLINE void turn_vector(double v[3], const mukca_geometry *geometry, int k, double s,
                              double c)
{
    const double *axis = geometry->axis[k];
    if (geometry->axis_z[k]) {
        const double sz = geometry->axis_z[k] * s, x = v[0];
        v[0] = c * x - sz * v[1];
        v[1] = sz * x + c * v[1];
        return;
    }
    double cross[3];
    mukca_cross(cross, axis, v);
    const double along = (1 - c) * mukca_dot3(axis, v);
    for (int i = 0; i < 3; i++) v[i] = c * v[i] + s * cross[i] + along * axis[i];
}

/* v := R v + p; z and p first, as x and y of v are available last. */
MUKCA_INLINE void place_vector(double v[3], const mukca_frame *frame)
{
    const double *R = frame->R, *p = frame->p, x = v[0], y = v[1], z = v[2];
    for (int i = 0; i < 3; i++)
        v[i] = (R[3 * i] * x + R[3 * i + 1] * y) + (R[3 * i + 2] * z + p[i]);
}

enum { WHOLE_JOINTS = (MUKCA_MAX_JOINTS + 3) / 4 * 4 };

/* Displaced angles (prismatic joints: lengths) of all joints; sines and cosines (unused for
 * lengths). */
typedef struct {
    const double *q; /* the caller's, or `moved` */
    LANES_ALIGNED double moved[WHOLE_JOINTS], s[WHOLE_JOINTS], c[WHOLE_JOINTS];
} joint_angles;

void mukca_joint_angles_set(joint_angles *at, const mukca_geometry *geometry, const double *q,
                            const mukca_displacement *displacement);

/* mukca_fk_position without a displacement. */
void mukca_fk_tip(double position[3], const mukca_geometry *geometry, const double *q);

/* v := v in the frame before element k, without a displacement by effects. */
MUKCA_INLINE void back_vector(double v[3], const mukca_geometry *geometry, int k,
                              const joint_angles *at)
{
    const int j = geometry->joint[k];
    if (geometry->type[k] == MUKCA_PRISMATIC)
        for (int i = 0; i < 3; i++) v[i] += at->q[j] * geometry->axis[k][i];
    else if (j >= 0)
        turn_vector(v, geometry, k, at->s[j], at->c[j]);
}

#endif
