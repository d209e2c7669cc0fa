/* Jacobian of the corrected arm: the equilibrium under load moves with the joints' angles. */
#include "arm/corrected_jacobian.h"

#include <string.h>

/* One in the lane of joint l, 0 in the others; l in [-MUKCA_MAX_JOINTS, MUKCA_MAX_JOINTS]. */
static const double lane_of[2 * MUKCA_MAX_JOINTS + MUKCA_LANES] = {[MUKCA_MAX_JOINTS] = 1};
#define IN_LANE(l) LOAD_LANES(lane_of + MUKCA_MAX_JOINTS - (l))

/* Rates without load as joints `first`, `first` + 1, ... turn. */
PART void set_unloaded(mukca_posture_rates *r, const mukca_equilibrium *e,
                       const mukca_effect_slopes *slopes, int first)
{
    for (int i = 0; i < 3; i++) r->base[i] = (lanes){0};
    for (int j = 0; j < e->n_joints; j++) {
        const double *by = slopes->angle[j], *rotation = slopes->rotation[j];
        const lanes own = IN_LANE(j - first);
        r->angle[j] = by[0] * IN_LANE(j - 1 - first) + by[1] * own + by[2] * IN_LANE(j + 1 - first);
        for (int i = 0; i < 3 && e->joint[j].tilts; i++) r->rotation[j][i] = rotation[i] * own;
    }
}

/* Columns `first`, `first` + 1, ... of the Jacobian. */
PART void fill_columns(double *J, const mukca_posture_rates *r, const mukca_equilibrium *e,
                       int first)
{
    const int n = e->n_joints;
    lanes v[3] = {0}, w[3] = {r->base[0], r->base[1], r->base[2]};
    for (int j = 0; j < n; j++) {
        const mukca_joint_posture *at = &e->joint[j];
        const double *axis = XYZ(at->axis), *p = XYZ(at->frame.column[3]);
        const lanes angle = r->angle[j];
        lanes turn[3] = {angle * axis[0], angle * axis[1], angle * axis[2]};
        for (int i = 0; i < 3 && at->slides; i++) v[i] += turn[i], turn[i] = (lanes){0};
        for (int i = 0; i < 3 && at->tilts; i++) turn[i] += r->rotation[j][i];
        for (int i = 0; i < 3; i++) {
            const int a = (i + 1) % 3, b = (i + 2) % 3;
            w[i] += turn[i];
            v[i] += p[a] * turn[b] - p[b] * turn[a];
        }
    }
    for (int i = 0; i < 3; i++) {
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        v[i] -= e->tip.p[a] * w[b] - e->tip.p[b] * w[a];
    }
    for (int i = 0; i < 3; i++)
        for (int l = 0; l < MUKCA_LANES && first + l < n; l++) {
            J[i * n + first + l] = ((const double *)&v[i])[l];
            J[(3 + i) * n + first + l] = ((const double *)&w[i])[l];
        }
}

MUKCA_CLONES void mukca_corrected_differentiate(double *J, mukca_equilibrium *e,
                                                mukca_effect_slopes *slopes)
{
    mukca_posture_rates r;
    mukca_equilibrium_rates(e, slopes);
    for (int first = 0; first < e->n_joints; first += MUKCA_LANES) {
        set_unloaded(&r, e, slopes, first);
        mukca_equilibrium_settle(&r, e, false, 2e-11);
        fill_columns(J, &r, e, first);
    }
}
