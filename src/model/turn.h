/* A joint turns a vector or a frame (Rodrigues). */
#ifndef MUKCA_MODEL_TURN_H
#define MUKCA_MODEL_TURN_H

#include "mukca/chain.h"

/* v := R(axis of element k, angle) v, given the angle's sine and cosine. */
static inline void turn_vector(double v[3], const mukca_geometry *geometry, int k, double s,
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

/* R := R R(axis of element k, angle): the rows of R turn backwards. */
static inline void turn_rows(double R[9], const mukca_geometry *geometry, int k, double s, double c)
{
    for (int row = 0; row < 3; row++) turn_vector(R + 3 * row, geometry, k, -s, c);
}

#endif
