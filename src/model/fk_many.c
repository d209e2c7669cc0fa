/* Tip positions of many configurations at once, one per lane. */
#include "math/sincos_lanes.h"
#include "model/turn.h"

#if MUKCA_LANES == 1

void mukca_fk_positions(double *positions, const mukca_geometry *geometry, const double *q,
                        int rows)
{
    for (int r = 0; r < rows; r++)
        mukca_fk_tip(positions + 3 * r, geometry, q + r * geometry->n_joints);
}

#else

/* v := R(axis of element k, angles) v: the operations of turn_vector in the same order, for
 * identical bits. */
MUKCA_INLINE void turn_lanes(lanes v[3], const mukca_geometry *geometry, int k, const double *sines,
                             const double *cosines)
{
    const double *a = geometry->axis[k];
    const lanes x = v[0], y = v[1], z = v[2], s = LOAD_LANES(sines), c = LOAD_LANES(cosines);
    if (geometry->axis_z[k]) {
        const lanes sz = geometry->axis_z[k] * s;
        v[0] = c * x - sz * y;
        v[1] = sz * x + c * y;
        return;
    }
    const lanes along = (1 - c) * (a[0] * x + a[1] * y + a[2] * z);
    v[0] = c * x + s * (a[1] * z - a[2] * y) + along * a[0];
    v[1] = c * y + s * (a[2] * x - a[0] * z) + along * a[1];
    v[2] = c * z + s * (a[0] * y - a[1] * x) + along * a[2];
}

/* Tips v[3] of the configurations at row[MUKCA_LANES]; bits are set in `wide` if an angle exceeds
 * the range of the sine kernel. */
MUKCA_INLINE void positions_lanes(lanes v[3], lane_bits *wide, const mukca_geometry *geometry,
                                  const double *const *row)
{
    for (int i = 0; i < 3; i++) v[i] = (lanes){0};
    for (int k = geometry->n_elements - 1; k >= 0; k--) {
        const int j = geometry->joint[k];
        const double *R = geometry->origin[k].R, *p = geometry->origin[k].p;
        if (j >= 0) {
            const lanes angle = {row[0][j], row[1][j], row[2][j], row[3][j]};
            double s[MUKCA_LANES], c[MUKCA_LANES];
            if (geometry->type[k] == MUKCA_PRISMATIC) {
                for (int i = 0; i < 3; i++) v[i] += angle * geometry->axis[k][i];
            } else {
                sincos_lanes(s, c, wide, (const double *)&angle);
                turn_lanes(v, geometry, k, s, c);
            }
        }
        const lanes x = v[0], y = v[1], z = v[2];
        for (int i = 0; i < 3; i++)
            v[i] = (R[3 * i] * x + R[3 * i + 1] * y) + (R[3 * i + 2] * z + p[i]);
    }
}

MUKCA_CLONES void mukca_fk_positions(double *positions, const mukca_geometry *geometry,
                                     const double *q, int rows)
{
    const int n = geometry->n_joints;
    for (int start = 0; start < rows; start += MUKCA_LANES) {
        const double *row[MUKCA_LANES];
        lane_bits wide = {0};
        lanes v[3];
        for (int l = 0; l < MUKCA_LANES; l++) /* the last block repeats the last row */
            row[l] = q + (size_t)(start + l < rows ? start + l : rows - 1) * (size_t)n;
        positions_lanes(v, &wide, geometry, row);
        for (int l = 0; l < MUKCA_LANES && start + l < rows; l++) {
            double *position = positions + 3 * (size_t)(start + l);
            if (ANY_LANE(wide))
                mukca_fk_tip(position, geometry, row[l]);
            else
                for (int i = 0; i < 3; i++) position[i] = v[i][l];
        }
    }
}

#endif
