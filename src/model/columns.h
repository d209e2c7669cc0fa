/* Frames as columns of lanes, and their motion by joints and displacements. */
#ifndef MUKCA_MODEL_COLUMNS_H
#define MUKCA_MODEL_COLUMNS_H

#include <string.h>

#include "math/four.h"
#include "model/turn.h"

/* A frame by columns: x, y and z axes and origin, in base coordinates.  With several lanes a
 * column is one vector with 0 as its fourth component, else an array. */
enum { ROWS = MUKCA_LANES > 1 ? 1 : 3 };
typedef struct {
    lanes column[4][ROWS];
} columns;

/* Components of a vector; component `i` of column `c`. */
#define XYZ(vector) ((const double *)(vector))
#define COLUMN(F, c, i) (XYZ((F)->column[c])[i])

/* F := F R, R a rotation matrix. */
MUKCA_INLINE void columns_rotate(columns *F, const double R[9])
{
    for (int r = 0; r < ROWS; r++) {
        const lanes x = F->column[0][r], y = F->column[1][r], z = F->column[2][r];
        for (int i = 0; i < 3; i++) F->column[i][r] = x * R[i] + y * R[3 + i] + z * R[6 + i];
    }
}

/* out[ROWS] := v, from the frame's own to base coordinates (no shift). */
MUKCA_INLINE void columns_vector(lanes *out, const columns *F, const double v[3])
{
    for (int r = 0; r < ROWS; r++)
        out[r] = F->column[0][r] * v[0] + F->column[1][r] * v[1] + F->column[2][r] * v[2];
}

/* Shift the origin by v, in the frame's own coordinates. */
MUKCA_INLINE void columns_move(columns *F, const double v[3])
{
    lanes step[ROWS];
    columns_vector(step, F, v);
    for (int r = 0; r < ROWS; r++) F->column[3][r] += step[r];
}

/* F := F times the motion of element k's joint at its angle or length. */
MUKCA_INLINE void columns_turn(columns *F, const mukca_geometry *geometry, int k,
                               const joint_angles *at)
{
    const int j = geometry->joint[k];
    const double *axis = geometry->axis[k];
    if (j < 0) return;
    const double s = at->s[j], c = at->c[j], sz = geometry->axis_z[k] * s;
    for (int r = 0; r < ROWS; r++) {
        const lanes x = F->column[0][r], y = F->column[1][r], z = F->column[2][r];
        if (geometry->type[k] == MUKCA_PRISMATIC) {
            F->column[3][r] += at->q[j] * (x * axis[0] + y * axis[1] + z * axis[2]);
        } else if (geometry->axis_z[k]) {
            F->column[0][r] = c * x + sz * y;
            F->column[1][r] = c * y - sz * x;
        } else {
            const lanes along = (1 - c) * (x * axis[0] + y * axis[1] + z * axis[2]);
            F->column[0][r] = c * x + s * (axis[2] * y - axis[1] * z) + along * axis[0];
            F->column[1][r] = c * y + s * (axis[0] * z - axis[2] * x) + along * axis[1];
            F->column[2][r] = c * z + s * (axis[1] * x - axis[0] * y) + along * axis[2];
        }
    }
}

/* F := F times the fixed transform of element k. */
MUKCA_INLINE void columns_enter(columns *F, const mukca_geometry *geometry, int k)
{
    columns_move(F, geometry->origin[k].p);
    columns_rotate(F, geometry->origin[k].R);
}

/* F := F R, R the rotation by the vector w. */
MUKCA_INLINE void columns_bend(columns *F, const double w[3])
{
    double R[9];
    mukca_rotation_exp(R, w);
    columns_rotate(F, R);
}

/* Rotation vector of joint j's frame before its rotation; NULL: none. */
static inline const double *joint_rotation(const mukca_displacement *displacement, int j)
{
    if (j < 0 || !displacement || !displacement->any_rotation) return NULL;
    const double *w = displacement->rotation[j];
    return w[0] != 0 || w[1] != 0 || w[2] != 0 ? w : NULL;
}

/* Rotate F by the joint's displacement, before the joint's rotation. */
MUKCA_INLINE void columns_displace(columns *F, int joint, const mukca_displacement *displacement)
{
    const double *w = joint_rotation(displacement, joint);
    if (w) columns_bend(F, w);
}

/* F := frame of the displaced base. */
MUKCA_INLINE void columns_base(columns *F, const mukca_displacement *displacement)
{
    memset(F, 0, sizeof *F);
    for (int i = 0; i < 3; i++) ((double *)F->column[i])[i] = 1;
    if (displacement && displacement->any_rotation) columns_bend(F, displacement->base);
}

MUKCA_INLINE void columns_frame(mukca_frame *frame, const columns *F)
{
    for (int i = 0; i < 3; i++) {
        for (int c = 0; c < 3; c++) frame->R[3 * i + c] = COLUMN(F, c, i);
        frame->p[i] = COLUMN(F, 3, i);
    }
}

#endif
